#pragma once
/// Image cycles of a study: NIfTI for the eye, JSON for the exact grid.

#include <filesystem>
#include <vector>

#include "pipeline/core/shapes.h"

namespace beatlas::study {

/// Writes without loss: 16-bit where every value is a whole number that fits, else float.
/// @param phases [phase][voxel]
/// @param lps_grid where the file shall lie, of as many voxels as a phase
void write_images(const std::filesystem::path& file, const std::vector<std::vector<float>>& phases,
                  const Grid& lps_grid, double frame_interval_s);
void write_labels(const std::filesystem::path& file,
                  const std::vector<std::vector<std::uint8_t>>& phases, const Grid& lps_grid,
                  double frame_interval_s);

/// What the file must hold, from the JSON beside it.
struct ExpectedImages {
  Grid lps_grid;  ///< where the file must lie, to a hundredth of a millimetre
  Grid grid;      ///< the exact grid that the result gets
  int phases = 0;
};

/// NIfTI keeps its map in single precision; the exact one of `expected` is returned.
/// @throws Error{InvalidInput} if size, phases or place of the file are others than expected.
[[nodiscard]] ImageCycle<float> read_images(const std::filesystem::path& file,
                                            const ExpectedImages& expected);
[[nodiscard]] LabelCycle read_labels(const std::filesystem::path& file,
                                     const ExpectedImages& expected);

}  // namespace beatlas::study
