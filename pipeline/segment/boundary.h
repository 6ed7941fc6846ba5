#pragma once
/// Sub-voxel edges: how much of a voxel at a boundary lies inside, from the intensities on its
/// two sides.

#include <vector>

#include "pipeline/core/grid.h"

namespace beatlas::segment {

/// @param image intensities; @param inside 1 in the structure; @param reference 1 where a voxel
/// may tell the inner level (e.g. only muscle, under an outer surface); same length
/// @param contrast least difference of the two levels that is trusted
/// @return coverage 0..1 of each voxel; 0.5 lies on the boundary. Where levels do not differ the
/// boundary runs between the voxels, smoothed.
[[nodiscard]] std::vector<float> boundary_coverage(const Grid& grid,
                                                   const std::vector<float>& image,
                                                   const std::vector<std::uint8_t>& inside,
                                                   const std::vector<std::uint8_t>& reference,
                                                   double contrast);

/// The same from the mask alone: coverage of its outline, smoothed in plane.
[[nodiscard]] std::vector<float> outline_coverage(const Grid& grid,
                                                  const std::vector<std::uint8_t>& inside);

}  // namespace beatlas::segment
