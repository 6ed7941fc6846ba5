#pragma once
/// Thick slices, each of a breath-hold with a brightness of its own.

#include <vector>

#include "pipeline/core/grid.h"

namespace beatlas::segment {

/// A gain multiplies blood and muscle alike: that of a slice is what both of the LV's have in
/// common beside the other slices'; inflow or partial volume, which change one of them, are none.
/// Slices beyond the LV take the step to their neighbour that most of their voxels show.
/// @param images the heart's box
/// @return [slice] about 1; empty where slices are thin, hardly differ, or no LV is found
[[nodiscard]] std::vector<double> slice_gains(const ImageCycle<float>& images);

[[nodiscard]] ImageCycle<float> without_slice_gains(ImageCycle<float> images,
                                                    const std::vector<double>& gains);

}  // namespace beatlas::segment
