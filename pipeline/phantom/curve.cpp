#include "pipeline/phantom/curve.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "pipeline/phantom/crossings.h"
#include "pipeline/phantom/solid.h"

namespace beatlas::phantom {

bool settle_on_curve(const Ellipsoid& a, const Ellipsoid& b, Vec3& x) {
  double last = 1e300;
  for (int iteration = 0; iteration < 30; ++iteration) {
    const Vec3 ga = a.gradient(x);
    const Vec3 gb = b.gradient(x);
    // Least-norm step J^T (J J^T)^-1 f.
    const double aa = ga.squaredNorm();
    const double bb = gb.squaredNorm();
    const double ab = ga.dot(gb);
    const double det = aa * bb - ab * ab;
    if (!(det > 1e-14 * aa * bb)) return false;
    const double fa = a.level(x);
    const double fb = b.level(x);
    const Vec3 step = ga * ((bb * fa - ab * fb) / det) + gb * ((aa * fb - ab * fa) / det);
    x -= step;
    const double size = step.norm();
    if (size <= 1e-12 || (size <= 1e-9 && size >= last)) return true;
    last = size;
  }
  return last < 1e-8;
}

bool settle_on_corner(const Ellipsoid& a, const Ellipsoid& b, const Ellipsoid& c, Vec3& x) {
  for (int iteration = 0; iteration < 30; ++iteration) {
    Eigen::Matrix3d gradients;
    gradients << a.gradient(x).transpose(), b.gradient(x).transpose(), c.gradient(x).transpose();
    const Vec3 values(a.level(x), b.level(x), c.level(x));
    const Vec3 step = gradients.fullPivLu().solve(values);
    if (!(step.norm() < 1e3)) return false;
    x -= step;
    if (step.norm() <= 1e-11) return true;
  }
  return false;
}

Vec3 curve_direction(const Ellipsoid& a, const Ellipsoid& b, const Vec3& x) {
  return a.gradient(x).cross(b.gradient(x)).normalized();
}

namespace {

/// Points of every curve in which the two meet that is no smaller than a step of the sections:
/// where sections of `a` across each axis cross `b`.
std::vector<Vec3> crossings(const Ellipsoid& a, const Ellipsoid& b) {
  constexpr int kSections = 24;
  std::vector<Vec3> out;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = std::max(a.centre_mm[axis] - a.semi_axes_mm[axis],
                                b.centre_mm[axis] - b.semi_axes_mm[axis]);
    const double high = std::min(a.centre_mm[axis] + a.semi_axes_mm[axis],
                                 b.centre_mm[axis] + b.semi_axes_mm[axis]);
    if (!(low < high)) return {};
    for (int n = 0; n < kSections; ++n) {
      AxisEllipse ellipse;
      if (!section(a, axis, low + (high - low) * (n + 0.5) / kSections, ellipse)) continue;
      for (double angle : crossing_angles(ellipse, b)) out.push_back(ellipse.point(angle));
    }
  }
  return out;
}

/// The curve from one of its points on, until it closes, is lost or has `most` points.
/// @param seeds, used [seed] set for those that the curve passes
Curve follow_curve(const Ellipsoid& a, const Ellipsoid& b, const Vec3& start, double step_mm,
                   std::size_t most, const std::vector<Vec3>& seeds, std::vector<bool>& used) {
  Curve curve;
  curve.step_mm = step_mm;
  Vec3 x = start;
  while (curve.points.size() < most) {
    curve.points.push_back(x);
    Vec3 next = x + 0.5 * step_mm * curve_direction(a, b, x);
    if (!settle_on_curve(a, b, next)) break;
    next = x + step_mm * curve_direction(a, b, next);
    if (!settle_on_curve(a, b, next)) break;
    for (std::size_t m = 0; m < seeds.size(); ++m) {
      if ((seeds[m] - x).norm() < 1.5 * step_mm) used[m] = true;
    }
    const double to_start = (next - start).norm();
    if (curve.points.size() > 3 && to_start < 0.75 * step_mm) break;
    x = next;
  }
  return curve;
}

}  // namespace

std::vector<Curve> intersection_curves(const Ellipsoid& a, const Ellipsoid& b, double step_mm) {
  if (a.is_cylinder() && b.is_cylinder()) return {};
  const bool from_b =
      a.is_cylinder() || (!b.is_cylinder() && b.semi_axes_mm.sum() < a.semi_axes_mm.sum());
  std::vector<Vec3> seeds = from_b ? crossings(b, a) : crossings(a, b);
  const double reach =
      from_b ? b.semi_axes_mm.sum() : a.semi_axes_mm.sum();  // no curve is longer than 20 of it
  std::vector<Curve> curves;
  std::vector<bool> used(seeds.size(), false);
  for (std::size_t n = 0; n < seeds.size(); ++n) {
    if (used[n]) continue;
    used[n] = true;
    Vec3 x = seeds[n];
    if (!settle_on_curve(a, b, x)) continue;  // ellipsoids that only touch have no crease
    const std::size_t most = static_cast<std::size_t>(20.0 * reach / step_mm);
    Curve curve = follow_curve(a, b, x, step_mm, most, seeds, used);
    if (curve.points.size() > 3) curves.push_back(std::move(curve));
  }
  return curves;
}

}  // namespace beatlas::phantom
