#include "pipeline/phantom/curve.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/LU>

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

Vec3 curve_direction(const Ellipsoid& a, const Ellipsoid& b, const Vec3& x) {
  return a.gradient(x).cross(b.gradient(x)).normalized();
}

namespace {

/// Where the ellipse of `a` in the plane y = its centre crosses `b`.
std::vector<Vec3> crossings(const Ellipsoid& a, const Ellipsoid& b) {
  const auto point = [&](double angle) -> Vec3 {
    return a.centre_mm +
           Vec3(a.semi_axes_mm.x() * std::cos(angle), 0.0, a.semi_axes_mm.z() * std::sin(angle));
  };
  constexpr int kSteps = 1440;
  std::vector<Vec3> out;
  for (int n = 0; n < kSteps; ++n) {
    double low = 2.0 * std::numbers::pi * n / kSteps;
    double high = 2.0 * std::numbers::pi * (n + 1) / kSteps;
    const bool low_inside = b.level(point(low)) < 0.0;
    if (low_inside == (b.level(point(high)) < 0.0)) continue;
    for (int iteration = 0; iteration < 60; ++iteration) {
      const double middle = 0.5 * (low + high);
      ((b.level(point(middle)) < 0.0) == low_inside ? low : high) = middle;
    }
    out.push_back(point(0.5 * (low + high)));
  }
  return out;
}

}  // namespace

std::vector<Curve> intersection_curves(const Ellipsoid& a, const Ellipsoid& b, double step_mm) {
  std::vector<Vec3> seeds = crossings(a, b);
  std::vector<Curve> curves;
  std::vector<bool> used(seeds.size(), false);
  for (std::size_t n = 0; n < seeds.size(); ++n) {
    if (used[n]) continue;
    used[n] = true;
    Vec3 x = seeds[n];
    if (!settle_on_curve(a, b, x)) continue;  // ellipsoids that only touch have no crease
    Curve curve;
    curve.step_mm = step_mm;
    const Vec3 start = x;
    const std::size_t most =
        static_cast<std::size_t>(20.0 * (a.semi_axes_mm.sum() + b.semi_axes_mm.sum()) / step_mm);
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
    if (curve.points.size() > 3) curves.push_back(std::move(curve));
  }
  return curves;
}

}  // namespace beatlas::phantom
