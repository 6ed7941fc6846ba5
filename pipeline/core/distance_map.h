#pragma once
#include <cstdint>
#include <vector>

#include "pipeline/core/grid.h"

namespace beatlas {

/// Exact Euclidean distance [mm] of every voxel centre to the nearest one in `mask` (not 0);
/// kNoDistance if the mask is empty. With `across_slices` false each slice stands alone: slices too
/// far apart say nothing about each other.
/// Method: lower envelope of parabolas (Felzenszwalb and Huttenlocher 2012), one axis at a time.
[[nodiscard]] std::vector<float> distance_map(const Grid& grid,
                                              const std::vector<std::uint8_t>& mask,
                                              bool across_slices);

inline constexpr float kNoDistance = 1e6F;

/// The same, where it is no more than `reach_mm`; farther off it is some greater number, less than
/// kNoDistance where there is a distance at all. Works around the mask only.
[[nodiscard]] std::vector<float> distance_near(const Grid& grid,
                                               const std::vector<std::uint8_t>& mask,
                                               bool across_slices, double reach_mm);

/// How deep [mm] each voxel of the mask lies: its distance to the nearest voxel that is not in it,
/// 0 outside; kNoDistance if the mask fills the grid.
[[nodiscard]] std::vector<float> depth_within(const Grid& grid,
                                              const std::vector<std::uint8_t>& mask,
                                              bool across_slices);

}  // namespace beatlas
