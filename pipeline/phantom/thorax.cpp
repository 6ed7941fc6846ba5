#include "pipeline/phantom/thorax.h"

#include <algorithm>
#include <limits>

namespace beatlas::phantom {

SignedPlane ThoraxBody::surface(const Vec3& lps) const {
  const Vec3 nearest = nearest_point(body, lps);
  return {(body.level(lps) < 0.0 ? -1.0 : 1.0) * (lps - nearest).norm(),
          body.gradient(nearest).normalized()};
}

std::vector<ThoraxBody> thorax(const Anatomy& anatomy, const Signals& signals) {
  const double k = std::max(1.0, anatomy.scale);
  const Vec3& origin = anatomy.origin_lps_mm;
  constexpr double kEndless = std::numeric_limits<double>::infinity();
  const auto cylinder = [&](double x, double y, double semi_x, double semi_y, double signal) {
    return ThoraxBody{{origin + k * Vec3(x, y, 0.0), {k * semi_x, k * semi_y, kEndless}}, signal};
  };
  const auto ellipsoid = [&](const Vec3& centre, const Vec3& semi, double signal) {
    return ThoraxBody{{origin + k * centre, k * semi}, signal};
  };
  return {
      cylinder(-14.0, 4.0, 122.0, 96.0, signals.fat),
      cylinder(-14.0, 4.0, 113.0, 87.0, signals.muscle),
      cylinder(-14.0, 4.0, 106.0, 80.0, signals.lung),
      ellipsoid({-44.0, -5.0, -118.0 + anatomy.liver_rise_mm}, {62.0, 54.0, 45.0}, signals.liver),
      cylinder(24.0, 62.0, 13.0, 13.0, signals.muscle),  // aorta, its wall
      cylinder(24.0, 62.0, 11.0, 11.0, signals.blood),
      cylinder(-6.0, 86.0, 15.0, 15.0, signals.bone),
  };
}

}  // namespace beatlas::phantom
