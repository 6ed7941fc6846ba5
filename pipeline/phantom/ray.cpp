#include "pipeline/phantom/ray.h"

#include <algorithm>
#include <cmath>

namespace beatlas::phantom {
namespace {

std::vector<double> crossings(const Below& plane, const Vec3& origin, const Vec3& direction) {
  if (direction.z() == 0.0) return {};
  return {(plane.z_mm - origin.z()) / direction.z()};
}

std::vector<double> crossings(const Ellipsoid& ellipsoid, const Vec3& origin,
                              const Vec3& direction) {
  // a s^2 + 2 b s + c = 0 in coordinates in which the ellipsoid is the unit ball; an infinite axis
  // makes its coordinate 0.
  const Vec3 from = (origin - ellipsoid.centre_mm).cwiseQuotient(ellipsoid.semi_axes_mm);
  const Vec3 along = direction.cwiseQuotient(ellipsoid.semi_axes_mm);
  const double a = along.squaredNorm();
  const double b = from.dot(along);
  const double c = from.squaredNorm() - 1.0;
  const double discriminant = b * b - a * c;
  if (!(a > 0.0) || !(discriminant > 0.0)) return {};
  const double q = -(b + std::copysign(std::sqrt(discriminant), b));
  return {std::min(q / a, c / q), std::max(q / a, c / q)};
}

}  // namespace

std::vector<double> crossings(const Primitive& primitive, const Vec3& origin,
                              const Vec3& direction) {
  return std::visit([&](const auto& each) { return crossings(each, origin, direction); },
                    primitive);
}

std::vector<Span> spans_inside(const std::vector<Primitive>& primitives,
                               const std::function<bool(const Vec3&)>& contains, const Vec3& origin,
                               const Vec3& direction, const Span& within) {
  std::vector<double> at{within.from_mm, within.to_mm};
  for (const Primitive& primitive : primitives) {
    for (const double s : crossings(primitive, origin, direction)) {
      if (s > within.from_mm && s < within.to_mm) at.push_back(s);
    }
  }
  std::sort(at.begin(), at.end());
  std::vector<Span> out;
  for (std::size_t n = 1; n < at.size(); ++n) {
    if (!(at[n] > at[n - 1])) continue;
    if (!contains(origin + 0.5 * (at[n - 1] + at[n]) * direction)) continue;
    if (!out.empty() && out.back().to_mm == at[n - 1]) {
      out.back().to_mm = at[n];
    } else {
      out.push_back({at[n - 1], at[n]});
    }
  }
  return out;
}

std::vector<Span> spans_inside(const Solid& solid, const Vec3& origin, const Vec3& direction,
                               const Span& within) {
  return spans_inside(
      solid.primitives(), [&](const Vec3& x) { return solid.contains(x); }, origin, direction,
      within);
}

std::vector<Span> spans_in_lv_muscle(const Frame& frame, const Anatomy& anatomy,
                                     const Vec3& origin_lps, const Vec3& direction_lps,
                                     const Span& within) {
  const Affine to_lps = lps_from_heart(anatomy);
  const Affine to_heart = to_lps.inverse(Eigen::Isometry);
  return spans_inside(
      construction(frame.shape(), Part::LvMyocardium).primitives,
      [&](const Vec3& x) { return frame.contains(Structure::LvMyocardium, to_lps * x); },
      to_heart * origin_lps, to_heart.linear() * direction_lps, within);
}

}  // namespace beatlas::phantom
