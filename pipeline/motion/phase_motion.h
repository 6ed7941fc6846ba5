#pragma once
/// Where tissue goes from one phase to the next, in the plane of each slice.

#include <array>
#include <cstdint>
#include <vector>

#include "pipeline/core/grid.h"

namespace beatlas::motion {

/// Whole steps (along i, along j) from a voxel to where what it holds lies in another phase; the
/// place is within the slice.
using PlaneStep = std::array<std::int8_t, 2>;

struct PhaseMotion {
  /// [phase][voxel], to the phase after and to the one before, the cycle closed.
  std::vector<std::vector<PlaneStep>> to_next;
  std::vector<std::vector<PlaneStep>> to_previous;
};

/// Dense inverse search (Kroeger et al., ECCV 2016), each slice for itself. No step where the way
/// back does not confirm it: what is there came from elsewhere.
/// @param images intensities
/// @param top intensity; what is brighter counts as `top`  @pre top > 0
[[nodiscard]] PhaseMotion phase_motion(const ImageCycle<float>& images, double top);

}  // namespace beatlas::motion
