#include "pipeline/field/closest_triangle.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace beatlas::field {
namespace {

constexpr std::uint32_t kLeafTriangles = 4;

// Rounding to float moves a point by less than 4e-7 of its distance to the origin. Up to four
// times the surface's radius that is within this slack; farther out, within the share by which a
// box is taken to be nearer.
constexpr double kSlackOfRadius = 4e-6;
constexpr float kNearer = 1.F - 1e-5F;

// Directions of a box whose last axis is `normal`; the lattice's own if there is none.
Eigen::Matrix3d axes_along(const Vec3& normal) {
  const double length = normal.norm();
  if (!(length > 0)) return Eigen::Matrix3d::Identity();
  Eigen::Matrix3d axes;
  axes.row(2) = normal / length;
  axes.row(0) = axes.row(2).transpose().unitOrthogonal();
  axes.row(1) = axes.row(2).cross(axes.row(0));
  return axes;
}

double ratio(double part, double whole) { return whole > 0 ? part / whole : 0.0; }

}  // namespace

struct ClosestTriangle::Builder {
  struct Range {
    std::uint32_t first, last;
    [[nodiscard]] std::uint32_t size() const { return last - first; }
  };

  const TriangleSoup& surface;
  std::vector<Vec3> centres;
  std::vector<std::uint32_t> order;
  std::vector<Node> nodes;
  Vec3 origin = Vec3::Zero();
  double slack_mm = 0;  ///< by which each box is wider on every side

  explicit Builder(const TriangleSoup& of) : surface(of), order(of.triangles.size()) {
    Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
    Vec3 high = -low;
    centres.reserve(order.size());
    for (const auto& t : surface.triangles) {
      centres.emplace_back((surface.points[t[0]] + surface.points[t[1]] + surface.points[t[2]]) /
                           3.0);
      low = low.cwiseMin(centres.back());
      high = high.cwiseMax(centres.back());
    }
    std::iota(order.begin(), order.end(), 0U);
    origin = 0.5 * (low + high);
    for (const auto& t : surface.triangles) {
      for (const std::uint32_t v : t) {
        slack_mm = std::max(slack_mm, kSlackOfRadius * (surface.points[v] - origin).norm());
      }
    }
    node({0, static_cast<std::uint32_t>(order.size())});
  }

  /// Halves by the longest side of the centres' box.
  std::array<Range, 2> halves(Range range) {
    if (range.size() <= kLeafTriangles) return {range, Range{range.last, range.last}};
    Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
    Vec3 high = -low;
    for (std::uint32_t n = range.first; n < range.last; ++n) {
      low = low.cwiseMin(centres[order[n]]);
      high = high.cwiseMax(centres[order[n]]);
    }
    Eigen::Index axis = 0;
    (high - low).maxCoeff(&axis);
    const std::uint32_t middle = range.first + range.size() / 2;
    std::nth_element(order.begin() + range.first, order.begin() + middle,
                     order.begin() + range.last, [&](std::uint32_t a, std::uint32_t b) {
                       const double at_a = centres[a][axis];
                       const double at_b = centres[b][axis];
                       return at_a < at_b || (at_a == at_b && a < b);
                     });
    return {Range{range.first, middle}, Range{middle, range.last}};
  }

  void set_box(Node& node, Eigen::Index which, Range range) const {
    Vec3 normal = Vec3::Zero();
    for (std::uint32_t n = range.first; n < range.last; ++n) {
      const auto& t = surface.triangles[order[n]];
      const Vec3& a = surface.points[t[0]];
      normal += (surface.points[t[1]] - a).cross(surface.points[t[2]] - a);
    }
    const Eigen::Matrix3d axes = axes_along(normal);
    Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
    Vec3 high = -low;
    for (std::uint32_t n = range.first; n < range.last; ++n) {
      for (const std::uint32_t v : surface.triangles[order[n]]) {
        const Vec3 p = axes * (surface.points[v] - origin);
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
      }
    }
    for (std::size_t r = 0; r < 3; ++r) {
      const auto row = static_cast<Eigen::Index>(r);
      for (std::size_t c = 0; c < 3; ++c) {
        node.axes[3 * r + c][which] = static_cast<float>(axes(row, static_cast<Eigen::Index>(c)));
      }
      node.low[r][which] = static_cast<float>(low[row] - slack_mm);
      node.high[r][which] = static_cast<float>(high[row] + slack_mm);
    }
  }

  std::uint32_t node(Range range) {
    const auto self = static_cast<std::uint32_t>(nodes.size());
    nodes.emplace_back();
    const std::array<Range, 2> half = halves(range);
    const std::array<Range, 2> left = halves(half[0]);
    const std::array<Range, 2> right = halves(half[1]);
    const std::array<Range, 4> quarters{left[0], left[1], right[0], right[1]};
    for (std::size_t q = 0; q < 4; ++q) {
      set_box(nodes[self], static_cast<Eigen::Index>(q), quarters[q]);
      const bool is_leaf = quarters[q].size() <= kLeafTriangles;
      const Part part =
          is_leaf ? Part{quarters[q].first, quarters[q].size()} : Part{node(quarters[q]), 0};
      nodes[self].parts[q] = part;
    }
    return self;
  }
};

ClosestTriangle::ClosestTriangle(const TriangleSoup& surface) {
  if (surface.triangles.empty()) return;
  Builder built(surface);
  origin_ = built.origin;
  nodes_ = std::move(built.nodes);
  triangles_.reserve(surface.triangles.size());
  for (std::uint32_t n : built.order) {
    const auto& t = surface.triangles[n];
    std::array<Vec3, 3> p{surface.points[t[0]], surface.points[t[1]], surface.points[t[2]]};
    if ((p[1] - p[0]).cross(p[2] - p[0]).squaredNorm() == 0) {
      // Without area it is its longest side, which distance2_to takes as twice the same edge.
      const auto side = [&](std::size_t v) { return (p[(v + 1) % 3] - p[v]).squaredNorm(); };
      const std::size_t v =
          side(0) >= side(1) ? (side(0) >= side(2) ? 0 : 2) : (side(1) >= side(2) ? 1 : 2);
      p = {p[v], p[(v + 1) % 3], p[(v + 1) % 3]};
    }
    triangles_.push_back({p[0], p[1] - p[0], p[2] - p[0]});
  }
}

// Ericson, Real-Time Collision Detection, 5.1.5: the Voronoi regions of a triangle.
double ClosestTriangle::distance2_to(const Vec3& mm, std::uint32_t triangle) const noexcept {
  const Triangle& t = triangles_[triangle];
  const Vec3 ap = mm - t.a;
  const double d1 = t.ab.dot(ap);
  const double d2 = t.ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return ap.squaredNorm();
  const Vec3 bp = ap - t.ab;
  const double d3 = t.ab.dot(bp);
  const double d4 = t.ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return bp.squaredNorm();
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return (ap - ratio(d1, d1 - d3) * t.ab).squaredNorm();
  const Vec3 cp = ap - t.ac;
  const double d5 = t.ab.dot(cp);
  const double d6 = t.ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return cp.squaredNorm();
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return (ap - ratio(d2, d2 - d6) * t.ac).squaredNorm();
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double share = ratio(d4 - d3, (d4 - d3) + (d5 - d6));
    return (bp - share * (t.ac - t.ab)).squaredNorm();
  }
  const double whole = va + vb + vc;
  return (ap - ratio(vb, whole) * t.ab - ratio(vc, whole) * t.ac).squaredNorm();
}

ClosestTriangle::Hit ClosestTriangle::nearest(const Vec3& mm, Hit bound) const noexcept {
  if (nodes_.empty()) return bound;
  struct Pending {
    Part part;
    float distance2;
  };
  const Vec3f at = (mm - origin_).cast<float>();
  // Each level leaves three of its four parts behind, and a 32-bit count has 16 levels.
  std::array<Pending, 64> stack;
  std::size_t top = 0;
  stack[top++] = {{0, 0}, 0.F};
  while (top > 0) {
    const Pending next = stack[--top];
    if (static_cast<double>(next.distance2) >= bound.distance2_mm2) continue;
    if (next.part.count > 0) {
      for (std::uint32_t n = next.part.first; n < next.part.first + next.part.count; ++n) {
        const double d2 = distance2_to(mm, n);
        if (d2 < bound.distance2_mm2) bound = {d2, n};
      }
      continue;
    }
    const Node& node = nodes_[next.part.first];
    Four distance2 = Four::Zero();
    for (std::size_t r = 0; r < 3; ++r) {
      const Four p =
          node.axes[3 * r] * at[0] + node.axes[3 * r + 1] * at[1] + node.axes[3 * r + 2] * at[2];
      distance2 += (node.low[r] - p).max(p - node.high[r]).max(0.F).square();
    }
    distance2 *= kNearer;
    // The nearest comes last, to be taken first.
    const std::size_t bottom = top;
    for (std::size_t q = 0; q < 4; ++q) {
      const float d2 = distance2[static_cast<Eigen::Index>(q)];
      if (static_cast<double>(d2) >= bound.distance2_mm2) continue;
      std::size_t to = top++;
      for (; to > bottom && stack[to - 1].distance2 < d2; --to) stack[to] = stack[to - 1];
      stack[to] = {node.parts[q], d2};
    }
  }
  return bound;
}

}  // namespace beatlas::field
