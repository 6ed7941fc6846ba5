#pragma once
/// The smooth surface that a mask of voxels leaves open.

#include <cstdint>
#include <vector>

#include "pipeline/core/grid.h"

namespace beatlas::edges {

/// Coverage 0..1 of a mask's voxels by a smooth body that the mask could be of; slices thinner than
/// kThickSlicesMm. A smooth distance is shifted, alike over some millimetres, until its sign around
/// each voxel is the mask's, and smoothed again by what leaves quadrics as they are, in turn (after
/// Whitaker, Reducing aliasing artifacts in iso-surfaces of binary volumes, IEEE VolVis 2000, where
/// the surface flows by its curvature instead, which shrinks it). Where signs still ask for a
/// shift, along edges and thin parts, it gives way to outline_coverage. What the grid cuts goes on
/// beyond it.
[[nodiscard]] std::vector<float> smooth_coverage(const Grid& grid,
                                                 const std::vector<std::uint8_t>& inside);

}  // namespace beatlas::edges
