// Triangles of a mesh that pass through each other. CGAL decides, exactly; what is cheaply seen to
// lie apart is not asked.
#include <algorithm>
#include <array>
#include <limits>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include "pipeline/mesh/triangle_mesh.h"

namespace beatlas::mesh {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;

Point exact(const Vec3& p) { return {p.x(), p.y(), p.z()}; }

// Triangles in the cells of a lattice that their boxes touch, cell by cell.
class Cells {
 public:
  // They lie about those `among`, and what none of those touches stays empty; without such a list
  // all are filled.
  Cells(std::span<const Vec3> points, std::span<const Triangle> triangles,
        const std::vector<bool>& among)
      : boxes_(triangles.size()) {
    Eigen::AlignedBox3d near;
    double edges = 0;
    for (std::size_t n = 0; n < triangles.size(); ++n) {
      for (const std::uint32_t v : triangles[n]) boxes_[n].extend(points[v]);
      if (among.empty() || among[n]) near.extend(boxes_[n]);
      edges += boxes_[n].sizes().maxCoeff();
    }
    if (near.isEmpty()) return;
    low_ = near.min();
    edge_ = std::max(edges / static_cast<double>(triangles.size()),
                     near.sizes().maxCoeff() / kMostCells);
    if (!(edge_ > 0)) edge_ = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      size_[axis] =
          static_cast<std::size_t>(near.sizes()[static_cast<Eigen::Index>(axis)] / edge_) + 1;
    }
    std::vector<std::uint32_t> candidates;
    for (std::uint32_t n = 0; n < boxes_.size(); ++n) {
      if (near.intersects(boxes_[n])) candidates.push_back(n);
    }
    const std::size_t cells = size_[0] * size_[1] * size_[2];
    std::vector<char> asked(cells, among.empty() ? 1 : 0);
    for (std::size_t n = 0; n < among.size(); ++n) {
      if (among[n]) each_cell(boxes_[n], [&](std::size_t cell) { asked[cell] = 1; });
    }
    first_.assign(cells + 1, 0);
    for (const std::uint32_t n : candidates) {
      each_cell(boxes_[n], [&](std::size_t cell) { first_[cell + 1] += asked[cell] != 0 ? 1 : 0; });
    }
    for (std::size_t n = 1; n < first_.size(); ++n) first_[n] += first_[n - 1];
    members_.resize(first_.back());
    std::vector<std::uint32_t> filled(first_.begin(), first_.end() - 1);
    for (const std::uint32_t n : candidates) {
      each_cell(boxes_[n], [&](std::size_t cell) {
        if (asked[cell] != 0) members_[filled[cell]++] = n;
      });
    }
  }

  // Calls visit(a, b), a < b, once for each two whose boxes touch and that are asked for.
  template <class Asked, class Visit>
  void each_pair(const Asked& asked, const Visit& visit) const {
    for (std::size_t cell = 0; cell + 1 < first_.size(); ++cell) {
      for (std::uint32_t n = first_[cell]; n < first_[cell + 1]; ++n) {
        const auto& one = boxes_[members_[n]];
        for (std::uint32_t m = n + 1; m < first_[cell + 1]; ++m) {
          if (!asked(members_[n], members_[m])) continue;
          const auto& other = boxes_[members_[m]];
          if (!one.intersects(other)) continue;
          // In the cell of the common box's lower corner alone.
          if (cell_of(one.min().cwiseMax(other.min())) != cell) continue;
          visit(members_[n], members_[m]);
        }
      }
    }
  }

 private:
  // What lies beyond the cells counts as in the last.
  std::size_t index(const Vec3& p, std::size_t axis) const {
    const auto row = static_cast<Eigen::Index>(axis);
    const double at = std::max(0.0, (p[row] - low_[row]) / edge_);
    return std::min(static_cast<std::size_t>(at), size_[axis] - 1);
  }
  std::size_t cell_of(const Vec3& p) const {
    return index(p, 0) + size_[0] * (index(p, 1) + size_[1] * index(p, 2));
  }
  template <class Visit>
  void each_cell(const Eigen::AlignedBox3d& box, const Visit& visit) const {
    for (std::size_t k = index(box.min(), 2); k <= index(box.max(), 2); ++k) {
      for (std::size_t j = index(box.min(), 1); j <= index(box.max(), 1); ++j) {
        for (std::size_t i = index(box.min(), 0); i <= index(box.max(), 0); ++i) {
          visit(i + size_[0] * (j + size_[1] * k));
        }
      }
    }
  }

  static constexpr double kMostCells = 128;  // along an axis

  std::vector<Eigen::AlignedBox3d> boxes_;
  Vec3 low_;
  double edge_ = 0;
  std::array<std::size_t, 3> size_{};
  std::vector<std::uint32_t> first_;
  std::vector<std::uint32_t> members_;
};

class Pair {
 public:
  Pair(std::span<const Vec3> points, const Triangle& a, const Triangle& b)
      : points_(points), a_(a), b_(b) {
    // Turned so that what both have comes first.
    for (std::size_t n = 0; n < 3; ++n) {
      for (std::size_t m = 0; m < 3; ++m) {
        if (a[n] != b[m]) continue;
        if (shared_ == 0) {
          a_ = {a[n], a[(n + 1) % 3], a[(n + 2) % 3]};
          b_ = {b[m], b[(m + 1) % 3], b[(m + 2) % 3]};
        }
        ++shared_;
      }
    }
  }

  [[nodiscard]] bool crosses() const {
    if (shared_ == 3) return true;
    if (shared_ == 2) return folds_flat();
    if (apart()) return false;
    if (shared_ == 0) return CGAL::do_intersect(triangle(a_), triangle(b_));
    return CGAL::do_intersect(triangle(a_), opposite(b_)) ||
           CGAL::do_intersect(triangle(b_), opposite(a_));
  }

 private:
  const Vec3& at(std::uint32_t v) const { return points_[v]; }
  Kernel::Triangle_3 triangle(const Triangle& t) const {
    return {exact(at(t[0])), exact(at(t[1])), exact(at(t[2]))};
  }
  Kernel::Segment_3 opposite(const Triangle& t) const { return {exact(at(t[1])), exact(at(t[2]))}; }

  // Whether two that share an edge lie in one plane and on the same side of it.
  bool folds_flat() const {
    std::array<std::uint32_t, 2> edge{};
    std::uint32_t apex = 0;
    std::size_t count = 0;
    for (const std::uint32_t v : a_) {
      if (v == b_[0] || v == b_[1] || v == b_[2]) {
        edge[count++] = v;
      } else {
        apex = v;
      }
    }
    std::uint32_t other = 0;
    for (const std::uint32_t v : b_) {
      if (v != edge[0] && v != edge[1]) other = v;
    }
    const Vec3 along = at(edge[1]) - at(edge[0]);
    const Vec3 one = along.cross(at(apex) - at(edge[0]));
    const Vec3 two = along.cross(at(other) - at(edge[0]));
    if (one.dot(two) < -kSure * one.norm() * two.norm()) return false;
    const Point p = exact(at(edge[0]));
    const Point q = exact(at(edge[1]));
    return CGAL::coplanar(p, q, exact(at(apex)), exact(at(other))) &&
           CGAL::coplanar_orientation(p, q, exact(at(apex)), exact(at(other))) == CGAL::POSITIVE;
  }

  // Whether a plane is seen to lie between both, through the shared corner if there is one.
  bool apart() const {
    const Vec3 middle_a = (at(a_[0]) + at(a_[1]) + at(a_[2])) / 3;
    const Vec3 middle_b = (at(b_[0]) + at(b_[1]) + at(b_[2])) / 3;
    const auto separates = [&](const Vec3& normal) {
      // Of each the least or the most along the normal; a shared corner lies on the plane.
      double low_a = std::numeric_limits<double>::infinity();
      double high_b = -low_a;
      double size = 0;
      for (std::size_t n = shared_ == 1 ? 1 : 0; n < 3; ++n) {
        const Vec3 from_a = at(a_[n]) - at(a_[0]);
        const Vec3 from_b = at(b_[n]) - at(a_[0]);
        low_a = std::min(low_a, normal.dot(from_a));
        high_b = std::max(high_b, normal.dot(from_b));
        size = std::max({size, from_a.cwiseAbs().maxCoeff(), from_b.cwiseAbs().maxCoeff()});
      }
      const double sure = kSure * size * normal.cwiseAbs().sum();
      return shared_ == 1 ? low_a > sure && high_b < -sure : low_a > high_b + sure;
    };
    if (separates(middle_a - middle_b)) return true;
    const auto normal = [&](const Triangle& t) -> Vec3 {
      return (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0]));
    };
    if (shared_ == 1) return false;
    const Vec3 of_a = normal(a_);
    const Vec3 of_b = normal(b_);
    return separates(of_a) || separates(-of_a) || separates(of_b) || separates(-of_b);
  }

  static constexpr double kSure = 1e-9;  // a million times what rounding takes

  std::span<const Vec3> points_;
  Triangle a_;
  Triangle b_;
  int shared_ = 0;
};

}  // namespace

std::vector<std::pair<std::uint32_t, std::uint32_t>> self_intersections(
    std::span<const Vec3> points, std::span<const Triangle> triangles,
    const std::vector<bool>& among) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> out;
  if (triangles.empty()) return out;
  Cells(points, triangles, among)
      .each_pair(
          [&](std::uint32_t a, std::uint32_t b) { return among.empty() || among[a] || among[b]; },
          [&](std::uint32_t a, std::uint32_t b) {
            if (Pair(points, triangles[a], triangles[b]).crosses()) out.emplace_back(a, b);
          });
  std::sort(out.begin(), out.end());
  return out;
}

std::vector<std::pair<Triangle, Triangle>> crossings(std::span<const Vec3> points,
                                                     std::span<const Triangle> triangles,
                                                     std::span<const Vec3> other_points,
                                                     std::span<const Triangle> other_triangles) {
  std::vector<std::pair<Triangle, Triangle>> out;
  if (triangles.empty() || other_triangles.empty()) return out;
  std::vector<Vec3> corners;
  std::vector<Triangle> all;
  const auto add = [&](std::span<const Vec3> of, const Triangle& t) {
    const auto first = static_cast<std::uint32_t>(corners.size());
    for (const std::uint32_t v : t) corners.push_back(of[v]);
    all.push_back({first, first + 1, first + 2});
  };
  for (const Triangle& t : triangles) add(points, t);
  for (const Triangle& t : other_triangles) add(other_points, t);
  const auto own = static_cast<std::uint32_t>(triangles.size());
  Cells(corners, all, {})
      .each_pair([&](std::uint32_t a, std::uint32_t b) { return a < own && b >= own; },
                 [&](std::uint32_t a, std::uint32_t b) {
                   if (Pair(corners, all[a], all[b]).crosses()) {
                     out.emplace_back(triangles[a], other_triangles[b - own]);
                   }
                 });
  return out;
}

}  // namespace beatlas::mesh
