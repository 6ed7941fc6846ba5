#pragma once
/// Coverage in thinner slices than it was seen in. Where a surface lies level with thick voxels a
/// blend of their coverage wavers from slice to slice; how much of each is covered tells where in
/// it the surface runs.

#include <vector>

#include "pipeline/core/grid.h"

namespace beatlas::shape {

/// Into how many thinner slices each is parted: about as thick as pixels are wide, 1 to 1.5 mm.
[[nodiscard]] int parts_of_slices(const Grid& grid);

struct SubSlices {
  Grid grid;                    ///< the same place, `parts` times as many slices
  std::vector<float> coverage;  ///< its mean over a slice's parts is the slice's
};

/// In each partly covered voxel a plane across the gradient of the coverage around it (Youngs 1982)
/// that leaves it as much covered as it is (Scardovelli and Zaleski, J. Comput. Phys. 164, 2000).
/// @param parts >= 1
[[nodiscard]] SubSlices split_slices(const Grid& grid, const std::vector<float>& coverage,
                                     int parts);

}  // namespace beatlas::shape
