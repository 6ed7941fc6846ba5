#pragma once
#include <cstdint>
#include <vector>

#include "pipeline/core/grid.h"

namespace beatlas::segment {

/// Exact Euclidean distance [mm] of every voxel centre to the nearest one in `mask` (not 0);
/// kNoDistance if the mask is empty. With `across_slices` false each slice stands alone: slices too
/// far apart say nothing about each other.
/// Method: lower envelope of parabolas (Felzenszwalb and Huttenlocher 2012), one axis at a time.
[[nodiscard]] std::vector<float> distance_map(const Grid& grid,
                                              const std::vector<std::uint8_t>& mask,
                                              bool across_slices);

inline constexpr float kNoDistance = 1e6F;

}  // namespace beatlas::segment
