#pragma once
/// Stiffness measured at points, as an elastogram or a table has it, on the muscle of an atlas.

#include <vector>

#include "runtime/palpation/lv_wall.h"

namespace beatlas::palpation {

/// A modulus [kPa] beyond these is in another unit: myocardium has 1 to some 100.
inline constexpr double kLeastKpa = 0.05;
inline constexpr double kMostKpa = 1000;

struct MeasuredPoint {
  Vec3 mm = Vec3::Zero();  ///< workspace, at end-diastole
  double kpa = 0;          ///< modulus of elasticity, > 0
};

/// [vertex] [kPa]: of the points within `reach_mm` of the middle of the vertex's wall the mean,
/// each weighted by 1 / (distance^2 + (1 mm)^2) (Shepard 1968); 0 where there is none, or no wall.
/// @throws Error{InvalidInput} naming, from 1, the point that lies beyond its reach from all of the
/// muscle: a map of another heart or in another frame
[[nodiscard]] std::vector<float> kpa_of_wall(const LvWall& wall,
                                             const std::vector<MeasuredPoint>& points,
                                             double reach_mm);

}  // namespace beatlas::palpation
