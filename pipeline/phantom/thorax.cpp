#include "pipeline/phantom/thorax.h"

#include <algorithm>

namespace beatlas::phantom {

SignedPlane Tissue::surface(const Vec3& lps) const {
  SignedPlane out;
  Vec3 nearest;
  bool inside = false;
  if (const auto* ellipsoid = std::get_if<Ellipsoid>(&body)) {
    nearest = nearest_point(*ellipsoid, lps);
    inside = ellipsoid->level(lps) < 0.0;
    out.outward = ellipsoid->gradient(nearest).normalized();
  } else {
    const Ellipse& ellipse = std::get<Ellipse>(body);
    nearest = near_points(ellipse, lps).points[0];
    nearest.z() = lps.z();
    const Vec3 from_centre = lps - ellipse.centre_mm;
    const double u = from_centre.x() / ellipse.semi_x_mm;
    const double v = from_centre.y() / ellipse.semi_y_mm;
    inside = u * u + v * v < 1.0;
    const Vec3 at = nearest - ellipse.centre_mm;
    out.outward = Vec3(at.x() / (ellipse.semi_x_mm * ellipse.semi_x_mm),
                       at.y() / (ellipse.semi_y_mm * ellipse.semi_y_mm), 0.0)
                      .normalized();
  }
  out.distance_mm = (inside ? -1.0 : 1.0) * (lps - nearest).norm();
  return out;
}

std::vector<Tissue> thorax(const Anatomy& anatomy, const Signals& signals) {
  const double k = std::max(1.0, anatomy.scale);
  const Vec3& origin = anatomy.origin_lps_mm;
  const auto cylinder = [&](double x, double y, double semi_x, double semi_y, double signal) {
    return Tissue{Ellipse{origin + k * Vec3(x, y, 0.0), k * semi_x, k * semi_y}, signal};
  };
  const auto ellipsoid = [&](const Vec3& centre, const Vec3& semi, double signal) {
    return Tissue{Ellipsoid{origin + k * centre, k * semi}, signal};
  };
  return {
      cylinder(0.0, 0.0, 122.0, 92.0, signals.fat),
      cylinder(0.0, 0.0, 113.0, 83.0, signals.muscle),
      cylinder(0.0, 0.0, 104.0, 74.0, signals.lung),
      ellipsoid({-30.0, -5.0, -116.0}, {62.0, 54.0, 45.0}, signals.liver),
      cylinder(26.0, 50.0, 13.0, 13.0, signals.muscle),  // aorta, its wall
      cylinder(26.0, 50.0, 11.0, 11.0, signals.blood),
      cylinder(0.0, 64.0, 15.0, 15.0, signals.bone),
  };
}

}  // namespace beatlas::phantom
