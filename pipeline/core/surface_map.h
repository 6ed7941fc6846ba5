#pragma once
#include <cstdint>
#include <vector>

#include "runtime/atlas/structures.h"

namespace beatlas {

/// Names of places of a ventricle's wall, and its thickness there. Of one surface; [vertex] or
/// [phase][vertex]. Names belong to the muscle: they are those of the first phase and stay with the
/// vertex. All but segments are whole multiples of 1e-4, thickness of 0.01 mm, so that a study's
/// text holds them exactly.
struct SurfaceMap {
  Structure structure{};
  std::vector<float> long_axis;  ///< 0 at the wall's apical end .. 1 at the base plane, 0..1
  /// About the long axis, 0 in the middle of the anterior wall, towards the septum, 0..2 pi.
  std::vector<float> angle_rad;
  /// 1..17 (AHA 2002), see palpation/segments.h; 0 on the RV, whose wall has no such names.
  std::vector<std::uint8_t> segment;
  /// [mm] from endocardium to epicardium along the endocardium's normal; 0 where the vertex is on
  /// neither (the base), or no wall of less than 40 mm is met. On the RV that of the free wall, 0
  /// where there is none or the images do not resolve it.
  std::vector<std::vector<float>> thickness_mm;
};

}  // namespace beatlas
