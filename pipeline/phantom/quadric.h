#pragma once
/// Distance to ellipsoids and to axis-aligned ellipses of a plane.
/// Frame: the heart's own (see spec.h), whose axes are those of every ellipsoid; [mm].

#include <array>
#include <cmath>

#include "runtime/base/geometry.h"

namespace beatlas::phantom {

struct Ellipsoid {
  Vec3 centre_mm = Vec3::Zero();
  /// Along x, y, z; > 0; equal axes are fine. That along z may be infinite: a cylinder.
  Vec3 semi_axes_mm = Vec3::Ones();

  [[nodiscard]] bool is_cylinder() const { return std::isinf(semi_axes_mm.z()); }
  /// < 0 inside, 0 on the surface, -1 at the centre.
  [[nodiscard]] double level(const Vec3& x) const {
    return (x - centre_mm).cwiseQuotient(semi_axes_mm).squaredNorm() - 1.0;
  }
  /// Gradient of level [1/mm].
  [[nodiscard]] Vec3 gradient(const Vec3& x) const {
    return 2.0 * (x - centre_mm).cwiseQuotient(semi_axes_mm.cwiseProduct(semi_axes_mm));
  }
};

/// Points of a surface or curve where the distance to a query can have a local minimum; the first
/// is the nearest one. A surface of revolution may add others on the same circle: they are not
/// needed, as moving along the circle makes the distance smaller.
struct NearPoints {
  std::array<Vec3, 3> points;
  int count = 0;
};

/// Newton's method on the multiplier of Lagrange, one root a bracket: x_i = a_i^2 p_i / (a_i^2 + t)
/// with sum (a_i p_i / (a_i^2 + t))^2 = 1. A query on a plane of symmetry is moved off it by less
/// than 1e-9 of the longest axis, which changes no distance by more. Error below 1e-9 mm at the
/// sizes of a heart (tested against dense search).
[[nodiscard]] NearPoints near_points(const Ellipsoid& ellipsoid, const Vec3& query);
/// The first of near_points alone, at a third of the cost.
[[nodiscard]] Vec3 nearest_point(const Ellipsoid& ellipsoid, const Vec3& query);

/// An ellipse in a plane z = const with axes along x and y.
struct Ellipse {
  Vec3 centre_mm = Vec3::Zero();
  double semi_x_mm = 0;
  double semi_y_mm = 0;

  [[nodiscard]] Vec3 point(double angle) const {
    return centre_mm + Vec3(semi_x_mm * std::cos(angle), semi_y_mm * std::sin(angle), 0.0);
  }
};

/// The section of an ellipsoid by the plane z = z_mm; false if they do not meet.
[[nodiscard]] bool section(const Ellipsoid& ellipsoid, double z_mm, Ellipse& ellipse);

/// As for an ellipsoid, on the curve; the query may lie off the plane.
[[nodiscard]] NearPoints near_points(const Ellipse& ellipse, const Vec3& query);

}  // namespace beatlas::phantom
