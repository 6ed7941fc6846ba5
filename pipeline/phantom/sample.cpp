#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "pipeline/phantom/solid.h"

namespace beatlas::phantom {
namespace {

/// Angles that cut an ellipse (or the first `share` of a turn of it) into steps of about
/// `spacing_mm`, each at the middle of its step.
std::vector<double> even_angles(double semi_x, double semi_y, double from, double to,
                                double spacing_mm) {
  constexpr int kFine = 512;
  std::vector<double> length(kFine + 1, 0.0);
  const auto angle = [&](int n) { return from + (to - from) * n / kFine; };
  for (int n = 0; n < kFine; ++n) {
    const double a = angle(n);
    const double b = angle(n + 1);
    length[n + 1] = length[n] + std::hypot(semi_x * (std::cos(b) - std::cos(a)),
                                           semi_y * (std::sin(b) - std::sin(a)));
  }
  const int steps = std::max(1, static_cast<int>(std::lround(length[kFine] / spacing_mm)));
  std::vector<double> out;
  int n = 0;
  for (int step = 0; step < steps; ++step) {
    const double want = length[kFine] * (step + 0.5) / steps;
    while (n + 1 < kFine && length[n + 1] < want) ++n;
    const double part = (want - length[n]) / std::max(length[n + 1] - length[n], 1e-300);
    out.push_back(angle(n) + (angle(n + 1) - angle(n)) * part);
  }
  return out;
}

/// @param low, high a cylinder's ends
std::vector<Vec3> spread(const Ellipsoid& e, double low, double high, double spacing_mm) {
  std::vector<Vec3> points;
  const Vec3& s = e.semi_axes_mm;
  if (e.is_cylinder()) {
    const std::vector<double> angles =
        even_angles(s.x(), s.y(), 0.0, 2.0 * std::numbers::pi, spacing_mm);
    const int rings = std::max(1, static_cast<int>(std::lround((high - low) / spacing_mm)));
    for (int ring = 0; ring < rings; ++ring) {
      const double z = low + (high - low) * (ring + 0.5) / rings;
      for (double angle : angles) {
        points.emplace_back(e.centre_mm.x() + s.x() * std::cos(angle),
                            e.centre_mm.y() + s.y() * std::sin(angle), z);
      }
    }
    return points;
  }
  // Rings from pole to pole, even along the mean meridian.
  const double half_turn = std::numbers::pi / 2.0;
  for (double polar :
       even_angles(std::sqrt(s.x() * s.y()), s.z(), -half_turn, half_turn, spacing_mm)) {
    const double ring = std::cos(polar);
    const double z = s.z() * std::sin(polar);
    for (double angle : even_angles(s.x() * ring, s.y() * ring, 0.0, 4.0 * half_turn, spacing_mm)) {
      points.push_back(e.centre_mm +
                       Vec3(s.x() * ring * std::cos(angle), s.y() * ring * std::sin(angle), z));
    }
  }
  return points;
}

/// Over the box of all that the plane cuts.
std::vector<Vec3> spread(const Below& plane, const std::vector<Primitive>& primitives,
                         double spacing_mm) {
  Vec3 low = Vec3::Constant(1e300);
  Vec3 high = Vec3::Constant(-1e300);
  for (const Primitive& other : primitives) {
    const auto* ellipsoid = std::get_if<Ellipsoid>(&other);
    Ellipse ellipse;
    if (ellipsoid == nullptr || !section(*ellipsoid, plane.z_mm, ellipse)) continue;
    const Vec3 half(ellipse.semi_x_mm, ellipse.semi_y_mm, 0.0);
    low = low.cwiseMin(ellipse.centre_mm - half);
    high = high.cwiseMax(ellipse.centre_mm + half);
  }
  std::vector<Vec3> points;
  for (double y = low.y() + 0.5 * spacing_mm; y < high.y(); y += spacing_mm) {
    for (double x = low.x() + 0.5 * spacing_mm; x < high.x(); x += spacing_mm) {
      points.emplace_back(x, y, plane.z_mm);
    }
  }
  return points;
}

}  // namespace

std::vector<Vec3> Solid::sample(double spacing_mm) const {
  std::vector<Vec3> points;
  double lowest = 1e300;
  double highest = -1e300;
  for (const Primitive& primitive : primitives_) {
    const auto* ellipsoid = std::get_if<Ellipsoid>(&primitive);
    if (ellipsoid == nullptr) {
      lowest = std::min(lowest, std::get<Below>(primitive).z_mm);
      highest = std::max(highest, std::get<Below>(primitive).z_mm);
    } else if (!ellipsoid->is_cylinder()) {
      lowest = std::min(lowest, ellipsoid->centre_mm.z() - ellipsoid->semi_axes_mm.z());
      highest = std::max(highest, ellipsoid->centre_mm.z() + ellipsoid->semi_axes_mm.z());
    }
  }
  for (const Primitive& primitive : primitives_) {
    const auto* ellipsoid = std::get_if<Ellipsoid>(&primitive);
    const std::vector<Vec3> candidates =
        ellipsoid != nullptr ? spread(*ellipsoid, lowest, highest, spacing_mm)
                             : spread(std::get<Below>(primitive), primitives_, spacing_mm);
    std::copy_if(candidates.begin(), candidates.end(), std::back_inserter(points),
                 [&](const Vec3& x) { return on_boundary(x); });
  }
  return points;
}

}  // namespace beatlas::phantom
