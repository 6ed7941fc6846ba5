#pragma once
/// What the images themselves say before any growing: noise, motion, where the heart is.

#include <cstdint>
#include <vector>

#include "pipeline/core/exam.h"
#include "pipeline/core/stage_context.h"

namespace beatlas::tissue {

/// Statistics of each voxel over the cycle, on the cine's grid or a part of it.
struct TemporalStats {
  std::vector<float> mean;   ///< over the phases, each lightly smoothed in plane
  std::vector<float> swing;  ///< standard deviation over the phases, noise taken off
  double noise = 0;          ///< standard deviation of the noise in one phase
};

/// Puts `values` in another order. 0 of none.
[[nodiscard]] double median_of(std::vector<float>& values);

/// In-plane Gaussian smoothing of each slice; `sigma_mm` 0 copies.
[[nodiscard]] std::vector<float> smooth_in_plane(const Grid& grid, const std::vector<float>& image,
                                                 double sigma_mm);

/// Standard deviation of the noise in one phase, from voxels that hold signal.
[[nodiscard]] double noise_level(const ImageCycle<float>& images);

[[nodiscard]] TemporalStats temporal_stats(const ImageCycle<float>& images);

}  // namespace beatlas::tissue
