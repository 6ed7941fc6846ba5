#include "pipeline/field/closest_triangle.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace beatlas::field {
namespace {

constexpr std::uint32_t kLeafTriangles = 4;

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

ClosestTriangle::ClosestTriangle(const TriangleSoup& surface) {
  const auto count = static_cast<std::uint32_t>(surface.triangles.size());
  if (count == 0) return;
  std::vector<Vec3> centres;
  centres.reserve(count);
  for (const auto& t : surface.triangles) {
    centres.emplace_back((surface.points[t[0]] + surface.points[t[1]] + surface.points[t[2]]) /
                         3.0);
  }
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0U);
  nodes_.reserve(count);
  build(order, surface, centres, 0, count);
  triangles_.reserve(count);
  for (std::uint32_t n : order) {
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

std::uint32_t ClosestTriangle::build(std::vector<std::uint32_t>& order, const TriangleSoup& surface,
                                     const std::vector<Vec3>& centres, std::uint32_t first,
                                     std::uint32_t last) {
  const auto self = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  Vec3 centre_low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 centre_high = -centre_low;
  Vec3 normal = Vec3::Zero();
  for (std::uint32_t n = first; n < last; ++n) {
    const auto& t = surface.triangles[order[n]];
    const Vec3& a = surface.points[t[0]];
    normal += (surface.points[t[1]] - a).cross(surface.points[t[2]] - a);
    centre_low = centre_low.cwiseMin(centres[order[n]]);
    centre_high = centre_high.cwiseMax(centres[order[n]]);
  }
  const Eigen::Matrix3d axes = axes_along(normal);
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  for (std::uint32_t n = first; n < last; ++n) {
    for (std::uint32_t v : surface.triangles[order[n]]) {
      const Vec3 p = axes * surface.points[v];
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  }
  nodes_[self].axes = axes;
  nodes_[self].low = low;
  nodes_[self].high = high;
  if (last - first <= kLeafTriangles) {
    nodes_[self].first = first;
    nodes_[self].count = last - first;
    return self;
  }
  Eigen::Index axis = 0;
  (centre_high - centre_low).maxCoeff(&axis);
  const std::uint32_t middle = first + (last - first) / 2;
  std::nth_element(order.begin() + first, order.begin() + middle, order.begin() + last,
                   [&](std::uint32_t a, std::uint32_t b) {
                     const double at_a = centres[a][axis];
                     const double at_b = centres[b][axis];
                     return at_a < at_b || (at_a == at_b && a < b);
                   });
  build(order, surface, centres, first, middle);
  const std::uint32_t right = build(order, surface, centres, middle, last);
  nodes_[self].first = right;
  return self;
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
    std::uint32_t node;
    double distance2;
  };
  const auto distance2_to_box = [&](std::uint32_t n) {
    const Vec3 p = nodes_[n].axes * mm;
    return (nodes_[n].low - p).cwiseMax(p - nodes_[n].high).cwiseMax(0.0).squaredNorm();
  };
  // Halving a 32-bit count of triangles cannot go deeper than this.
  std::array<Pending, 64> stack;
  std::size_t top = 0;
  stack[top++] = {0, distance2_to_box(0)};
  while (top > 0) {
    const Pending next = stack[--top];
    if (next.distance2 >= bound.distance2_mm2) continue;
    const Node& node = nodes_[next.node];
    if (node.count > 0) {
      for (std::uint32_t n = node.first; n < node.first + node.count; ++n) {
        const double d2 = distance2_to(mm, n);
        if (d2 < bound.distance2_mm2) bound = {d2, n};
      }
      continue;
    }
    Pending left{next.node + 1, distance2_to_box(next.node + 1)};
    Pending right{node.first, distance2_to_box(node.first)};
    if (left.distance2 > right.distance2) std::swap(left, right);
    if (right.distance2 < bound.distance2_mm2) stack[top++] = right;
    if (left.distance2 < bound.distance2_mm2) stack[top++] = left;
  }
  return bound;
}

}  // namespace beatlas::field
