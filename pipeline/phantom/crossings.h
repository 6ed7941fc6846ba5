#pragma once
/// Where a plane section of one ellipsoid meets another.

#include <vector>

#include "pipeline/phantom/quadric.h"

namespace beatlas::phantom {

/// An ellipse in a plane across one of the frame's axes: centre + cos(angle) semi_p e_p +
/// sin(angle) semi_q e_q.
struct AxisEllipse {
  Vec3 centre_mm = Vec3::Zero();
  int p = 0;  ///< axis 0..2
  int q = 1;  ///< another axis
  double semi_p_mm = 0;
  double semi_q_mm = 0;

  AxisEllipse() = default;
  AxisEllipse(const Ellipse& ellipse)  // NOLINT(google-explicit-constructor): the case z = const
      : centre_mm(ellipse.centre_mm), semi_p_mm(ellipse.semi_x_mm), semi_q_mm(ellipse.semi_y_mm) {}

  [[nodiscard]] Vec3 point(double angle) const {
    Vec3 out = centre_mm;
    out[p] += semi_p_mm * std::cos(angle);
    out[q] += semi_q_mm * std::sin(angle);
    return out;
  }
};

/// The section of an ellipsoid by the plane x[axis] = at_mm; false if they do not meet, or the
/// section is no ellipse (a cylinder cut along its axis).
[[nodiscard]] bool section(const Ellipsoid& ellipsoid, int axis, double at_mm,
                           AxisEllipse& ellipse);

/// Angles in [0, 2 pi), ascending, at which the ellipse crosses the ellipsoid: at most four. Two
/// that lie closer than 1e-7 of a turn may be missed together (the ellipse all but touches).
[[nodiscard]] std::vector<double> crossing_angles(const AxisEllipse& ellipse,
                                                  const Ellipsoid& ellipsoid);

}  // namespace beatlas::phantom
