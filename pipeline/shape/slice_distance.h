#pragma once
#include <vector>

#include "pipeline/core/grid.h"

namespace beatlas::shape {

/// Signed in-plane distance [mm] (negative inside) of each slice to its coverage's 0.5 contour, at
/// sub-pixel precision (0.35 mm). A slice without the structure gets an empty vector.
/// @param coverage one phase on `grid`
[[nodiscard]] std::vector<std::vector<float>> slice_distances(const Grid& grid,
                                                              const std::vector<float>& coverage);

}  // namespace beatlas::shape
