#pragma once
#include "pipeline/phantom/heart_shape.h"

namespace beatlas::phantom {

/// The jet at the outlet of the LV: a cone about a line along z, open toward +z. Heart frame, [mm].
struct JetCone {
  Vec3 tip = Vec3::Zero();
  double length_mm = 0;  ///< along +z
  double slope = 0;      ///< radius over the distance from the tip
};

/// The cone at one moment: its axis is the aortic outlet's, its tip lies 25 mm below the valve and
/// its end 35 mm above it; at the valve it is 10 mm wide to each side. Lengths grow with the scale.
[[nodiscard]] JetCone jet_cone(const HeartShape& shape, double scale);

/// 1 in the cone, 0 outside, over 2 mm across its surface a smooth step in between.
[[nodiscard]] double jet_weight(const JetCone& cone, const Vec3& heart_mm);

/// Rate of ejection over its highest rate, 0 while the heart fills or rests. 0..1
[[nodiscard]] double ejection_rate(double t_s, double rr_interval_s);

}  // namespace beatlas::phantom
