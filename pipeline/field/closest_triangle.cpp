#include "pipeline/field/closest_triangle.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <span>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace beatlas::field {
namespace {

constexpr std::uint32_t kPack = 4;

// By which a part is wider than its triangles: what rounding to float moves a point by, and more.
constexpr double kSlackOfRadius = 1e-6;

// A part of so many is large beside each of them: balls around them tell where it ends.
constexpr std::uint32_t kManyFans = 128;

/// A bit for each of four that is less.
unsigned less(const Eigen::Array4f& four, float limit) {
#if defined(__SSE2__)
  return static_cast<unsigned>(
      _mm_movemask_ps(_mm_cmplt_ps(_mm_load_ps(four.data()), _mm_set1_ps(limit))));
#else
  unsigned out = 0;
  for (unsigned n = 0; n < 4; ++n) out |= four[static_cast<Eigen::Index>(n)] < limit ? 1U << n : 0U;
  return out;
#endif
}

}  // namespace

struct ClosestTriangle::Builder {
  struct Range {
    std::uint32_t first, last;
    [[nodiscard]] std::uint32_t size() const { return last - first; }
  };
  /// Triangles that follow one another around a common last vertex, as a contour's face gives them.
  struct Fan {
    std::uint32_t first, count;
    Vec3 centre;
    Vec3 normal;        ///< as long as twice its area
    double radius = 0;  ///< about the centre
  };

  const TriangleSoup& surface;
  std::vector<Fan> fans;
  std::vector<Node> nodes;
  std::vector<Pack> packs;
  Vec3 origin = Vec3::Zero();
  double slack_mm = 0;

  explicit Builder(const TriangleSoup& of) : surface(of) {
    const auto count = static_cast<std::uint32_t>(surface.triangles.size());
    Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
    Vec3 high = -low;
    for (std::uint32_t n = 0; n < count; ++n) {
      const auto& t = surface.triangles[n];
      const Vec3 centre =
          (surface.points[t[0]] + surface.points[t[1]] + surface.points[t[2]]) / 3.0;
      low = low.cwiseMin(centre);
      high = high.cwiseMax(centre);
      if (fans.empty() || fans.back().count == kPack || surface.triangles[n - 1][2] != t[2]) {
        fans.push_back({n, 0, Vec3::Zero(), Vec3::Zero()});
      }
      ++fans.back().count;
      fans.back().centre += centre;
    }
    for (std::uint32_t n = 0; n < fans.size(); ++n) {
      Fan& fan = fans[n];
      fan.centre /= fan.count;
      double radius2 = 0;
      corners({n, n + 1}, [&](const Vec3& a, const Vec3& b, const Vec3& c) {
        fan.normal += (b - a).cross(c - a);
        for (const Vec3* x : {&a, &b, &c}) {
          radius2 = std::max(radius2, (*x - fan.centre).squaredNorm());
        }
      });
      fan.radius = std::sqrt(radius2);
    }
    origin = 0.5 * (low + high);
    for (const auto& t : surface.triangles) {
      for (const std::uint32_t v : t) {
        slack_mm = std::max(slack_mm, kSlackOfRadius * (surface.points[v] - origin).norm());
      }
    }
    packs.reserve(fans.size());
    node({0, static_cast<std::uint32_t>(fans.size())});
  }

  [[nodiscard]] bool is_pack(Range range) const {
    if (range.size() > kPack) return false;
    std::uint32_t count = 0;
    for (std::uint32_t n = range.first; n < range.last; ++n) count += fans[n].count;
    return count <= kPack;
  }

  /// Halves by the longest side of the centres' box.
  std::array<Range, 2> halves(Range range) {
    if (is_pack(range)) return {range, Range{range.last, range.last}};
    Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
    Vec3 high = -low;
    for (std::uint32_t n = range.first; n < range.last; ++n) {
      low = low.cwiseMin(fans[n].centre);
      high = high.cwiseMax(fans[n].centre);
    }
    Eigen::Index axis = 0;
    (high - low).maxCoeff(&axis);
    const std::uint32_t middle = range.first + range.size() / 2;
    std::nth_element(fans.begin() + range.first, fans.begin() + middle, fans.begin() + range.last,
                     [&](const Fan& a, const Fan& b) {
                       const double at_a = a.centre[axis];
                       const double at_b = b.centre[axis];
                       return at_a < at_b || (at_a == at_b && a.first < b.first);
                     });
    return {Range{range.first, middle}, Range{middle, range.last}};
  }

  template <class Visit>
  void corners(Range range, const Visit& visit) const {
    for (std::uint32_t n = range.first; n < range.last; ++n) {
      for (std::uint32_t t = fans[n].first; t < fans[n].first + fans[n].count; ++t) {
        const auto& corner = surface.triangles[t];
        visit(surface.points[corner[0]], surface.points[corner[1]], surface.points[corner[2]]);
      }
    }
  }

  /// The cylinder around a part, its axis along the mean normal.
  void set_cylinder(Node& node, std::size_t which, Range range) const {
    const auto lane = static_cast<Eigen::Index>(which);
    Vec3 normal = Vec3::Zero();
    Vec3 centre = Vec3::Zero();
    double height = 0;
    double radius = -std::numeric_limits<double>::infinity();
    if (range.size() > 0) {
      for (std::uint32_t n = range.first; n < range.last; ++n) {
        normal += fans[n].normal;
        centre += fans[n].centre;
      }
      normal = normal.norm() > 0 ? normal.normalized() : Vec3::UnitZ();
      centre /= range.size();
      double low = std::numeric_limits<double>::infinity();
      double high = -low;
      const auto hold = [&](const Vec3& x, double around) {
        const Vec3 way = x - centre;
        const double up = normal.dot(way);
        low = std::min(low, up - around);
        high = std::max(high, up + around);
        radius = std::max(radius, (way - up * normal).norm() + around);
      };
      if (range.size() > kManyFans) {
        for (std::uint32_t n = range.first; n < range.last; ++n) {
          hold(fans[n].centre, fans[n].radius);
        }
      } else {
        corners(range, [&](const Vec3& a, const Vec3& b, const Vec3& c) {
          for (const Vec3* x : {&a, &b, &c}) hold(*x, 0);
        });
      }
      centre += 0.5 * (low + high) * normal;
      height = 0.5 * (high - low) + slack_mm;
      radius += slack_mm;
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto row = static_cast<Eigen::Index>(axis);
      node.centre[axis][lane] = static_cast<float>(centre[row] - origin[row]);
      node.normal[axis][lane] = static_cast<float>(normal[row]);
    }
    node.half_height[lane] = static_cast<float>(height);
    node.radius[lane] = static_cast<float>(radius);
  }

  std::uint32_t pack(Range range) {
    const auto self = static_cast<std::uint32_t>(packs.size());
    Pack& out = packs.emplace_back();
    Eigen::Index lane = 0;
    const auto put = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto row = static_cast<Eigen::Index>(axis);
        out.a[axis][lane] = static_cast<float>(a[row] - origin[row]);
        out.ab[axis][lane] = static_cast<float>(b[row] - a[row]);
        out.ac[axis][lane] = static_cast<float>(c[row] - a[row]);
      }
      ++lane;
    };
    corners(range, put);
    while (lane < static_cast<Eigen::Index>(kPack)) {
      for (FourPoints* points : {&out.a, &out.ab, &out.ac}) {
        for (Four& axis : *points) axis[lane] = axis[lane - 1];
      }
      ++lane;
    }
    return self;
  }

  std::uint32_t node(Range range) {
    const auto self = static_cast<std::uint32_t>(nodes.size());
    nodes.emplace_back();
    const std::array<Range, 2> half = halves(range);
    const std::array<Range, 2> left = halves(half[0]);
    const std::array<Range, 2> right = halves(half[1]);
    const std::array<Range, 4> quarters{left[0], left[1], right[0], right[1]};
    for (std::size_t q = 0; q < 4; ++q) {
      set_cylinder(nodes[self], q, quarters[q]);
      std::uint32_t part = kIsPack;
      if (quarters[q].size() > 0) {
        part = is_pack(quarters[q]) ? kIsPack | pack(quarters[q]) : node(quarters[q]);
      }
      nodes[self].part[q] = part;
    }
    return self;
  }
};

ClosestTriangle::ClosestTriangle(const TriangleSoup& surface) {
  if (surface.triangles.empty()) return;
  Builder built(surface);
  origin_ = built.origin;
  nodes_ = std::move(built.nodes);
  packs_ = std::move(built.packs);
}

inline ClosestTriangle::Four ClosestTriangle::distance2_to_parts(const Vec3f& at,
                                                                 const Node& node) noexcept {
  const Four x = at[0] - node.centre[0];
  const Four y = at[1] - node.centre[1];
  const Four z = at[2] - node.centre[2];
  const Four up = x * node.normal[0] + y * node.normal[1] + z * node.normal[2];
  const Four beside = ((x - up * node.normal[0]).square() + (y - up * node.normal[1]).square() +
                       (z - up * node.normal[2]).square())
                          .sqrt();
  return (up.abs() - node.half_height).max(0.F).square() + (beside - node.radius).max(0.F).square();
}

// The foot on the plane where that is within the triangle, and the nearest place of each side: the
// least of the four. Every one of them is a place of the triangle, so rounding is all that is lost.
inline ClosestTriangle::Four ClosestTriangle::distance2_to_pack(const Vec3f& at,
                                                                const Pack& pack) noexcept {
  constexpr float kTiny = 1e-30F;
  const Four px = at[0] - pack.a[0];
  const Four py = at[1] - pack.a[1];
  const Four pz = at[2] - pack.a[2];
  const auto dot = [](const FourPoints& u, const FourPoints& v) -> Four {
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
  };
  const FourPoints p{px, py, pz};
  const Four ab2 = dot(pack.ab, pack.ab);
  const Four ac2 = dot(pack.ac, pack.ac);
  const Four abac = dot(pack.ab, pack.ac);
  const Four d1 = dot(pack.ab, p);
  const Four d2 = dot(pack.ac, p);
  // Of the place a + v ab + w ac.
  const auto away2 = [&](const Four& v, const Four& w) -> Four {
    return (p[0] - v * pack.ab[0] - w * pack.ac[0]).square() +
           (p[1] - v * pack.ab[1] - w * pack.ac[1]).square() +
           (p[2] - v * pack.ab[2] - w * pack.ac[2]).square();
  };
  const auto share = [&](const Four& part, const Four& whole) -> Four {
    return (part / whole.max(kTiny)).max(0.F).min(1.F);
  };
  const Four zero = Four::Zero();
  const Four on_ab = share(d1, ab2);
  const Four on_ac = share(d2, ac2);
  const Four on_bc = share(d2 - d1 + ab2 - abac, ab2 - 2 * abac + ac2);
  Four least = away2(on_ab, zero).min(away2(zero, on_ac)).min(away2(1 - on_bc, on_bc));
  const Four v = ac2 * d1 - abac * d2;
  const Four w = ab2 * d2 - abac * d1;
  const Four area2 = ab2 * ac2 - abac * abac;
  const auto within = v >= 0.F && w >= 0.F && v + w <= area2 && area2 > 0.F;
  const Four whole = area2.max(kTiny);
  return within.select(least.min(away2(v / whole, w / whole)), least);
}

/// What is still to be looked at for one point, nearest last.
class ClosestTriangle::Search {
 public:
  Search(const ClosestTriangle& tree, const Vec3& mm, const Hit& bound)
      : tree_(tree), at_((mm - tree.origin_).cast<float>()), best_(bound) {}

  void open(const Node& node) {
    const Four distance2 = distance2_to_parts(at_, node);
    const unsigned near = less(distance2, best_.distance2_mm2);
    // All are written and those that are near kept, for a branch on each would be guessed wrong.
    for (unsigned n = 0; n < kPack; ++n) {
      stack_[top_] = {node.part[n], distance2[static_cast<Eigen::Index>(n)]};
      top_ += near >> n & 1U;
    }
  }

  void run() {
    while (top_ > 0) {
      const Pending next = stack_[--top_];
      if (next.distance2 >= best_.distance2_mm2) continue;
      if ((next.part & kIsPack) != 0) {
        look_at(next.part & ~kIsPack);
      } else {
        open(tree_.nodes_[next.part]);
      }
    }
  }

  [[nodiscard]] bool is_crowded() const { return top_ + kPack > kWidest; }

  void look_at(std::uint32_t pack) {
    const float least = distance2_to_pack(at_, tree_.packs_[pack]).minCoeff();
    if (least < best_.distance2_mm2) best_ = {least, pack};
  }

  [[nodiscard]] const Hit& best() const { return best_; }

 private:
  struct Pending {
    std::uint32_t part;
    float distance2;
  };

  static constexpr std::size_t kWidest = 32;

  const ClosestTriangle& tree_;
  Vec3f at_;
  Hit best_;
  // Each level leaves three of its four parts behind, and a 32-bit count has 16 levels.
  std::array<Pending, kWidest + 64> stack_;
  std::size_t top_ = 0;
};

ClosestTriangle::Hit ClosestTriangle::nearest(const Vec3& mm, Hit bound) const noexcept {
  if (nodes_.empty()) return bound;
  Search search(*this, mm, bound);
  search.open(nodes_.front());
  search.run();
  return search.best();
}

ClosestTriangle::Hit ClosestTriangle::nearest(const Vec3& mm, Hit bound,
                                              const Vicinity& about) const noexcept {
  Search search(*this, mm, bound);
  for (const Node& node : about.nodes_) {
    search.open(node);
    if (search.is_crowded()) search.run();
  }
  search.run();
  return search.best();
}

ClosestTriangle::Hit ClosestTriangle::nearest_of(std::uint32_t four, const Vec3& mm,
                                                 Hit bound) const noexcept {
  Search search(*this, mm, bound);
  search.look_at(four);
  return search.best();
}

void ClosestTriangle::gather(const Vec3& mm, double reach_mm, double part_mm,
                             const Vicinity* within, Vicinity& out) const {
  out.nodes_.clear();
  if (nodes_.empty()) return;
  const Vec3f at = (mm - origin_).cast<float>();
  const auto limit = static_cast<float>(reach_mm * reach_mm);
  const auto small = static_cast<float>(part_mm);
  std::array<std::uint32_t, 64> stack;
  std::size_t top = 0;
  std::size_t filled = kPack;
  const auto take = [&](const Node& node) {
    for (unsigned near = less(distance2_to_parts(at, node), limit); near != 0; near &= near - 1) {
      const auto from = static_cast<std::size_t>(std::countr_zero(near));
      const auto lane = static_cast<Eigen::Index>(from);
      if ((node.part[from] & kIsPack) == 0 && node.radius[lane] > small) {
        stack[top++] = node.part[from];
        continue;
      }
      if (filled == kPack) {
        out.nodes_.emplace_back();
        out.nodes_.back().radius.setConstant(-std::numeric_limits<float>::infinity());
        filled = 0;
      }
      Node& to = out.nodes_.back();
      const auto slot = static_cast<Eigen::Index>(filled);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        to.centre[axis][slot] = node.centre[axis][lane];
        to.normal[axis][slot] = node.normal[axis][lane];
      }
      to.half_height[slot] = node.half_height[lane];
      to.radius[slot] = node.radius[lane];
      to.part[filled++] = node.part[from];
    }
  };
  const std::span<const Node> start =
      within != nullptr ? std::span<const Node>(within->nodes_) : std::span(nodes_).first(1);
  for (const Node& node : start) {
    take(node);
    while (top > 0) take(nodes_[stack[--top]]);
  }
}

}  // namespace beatlas::field
