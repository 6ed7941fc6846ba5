#pragma once
/// Label images on grids of their own: what was painted or segmented in another program.

#include <vector>

#include "pipeline/core/shapes.h"
#include "pipeline/segment/options.h"

namespace beatlas::segment {

/// Value of voxels that nobody painted: 0 may stand for painted background.
inline constexpr std::uint8_t kNotPainted = 255;

/// What was painted in one image, as seeds on the grid of the images: a voxel of that grid is
/// marked if its centre lies in a painted voxel, or else if the centre of one lies in it (the
/// nearest to its own tells the label). Neighbours of a label in a row make one stroke, so that a
/// painting of 100 000 voxels is some thousands of seeds.
/// @param painted on `painted_grid`, LPS: labels, kNotPainted elsewhere
/// @param phase of the seeds; -1 = every phase
/// @return none where it is not painted, or only outside `grid`
[[nodiscard]] std::vector<Seed> seeds_of_painting(const Grid& painted_grid,
                                                  const std::vector<std::uint8_t>& painted,
                                                  int phase, const Grid& grid);

/// Labels on another grid: each voxel gets that of the voxel its centre lies in, 0 outside.
/// @param given, grid LPS
/// @param drawn_shifted_mm [slice of the grid] along its axes i and j: what was drawn at x + shift
/// belongs at x, as Exam::slice_shifts_mm; empty: no shift
/// @throws Error{InvalidInput} unless there is a shift for every slice or none
[[nodiscard]] LabelCycle labels_on_grid(const LabelCycle& given, const Grid& grid,
                                        const std::vector<Vec2>& drawn_shifted_mm = {});

}  // namespace beatlas::segment
