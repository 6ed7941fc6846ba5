#pragma once
/// Volumes of a segmentation, and the ends of the beat by them.

#include <vector>

#include "pipeline/core/shapes.h"

namespace beatlas {

/// Volume [ml] of a structure in every phase: its coverage, each slice as thick as slices are
/// apart. Empty if the structure was not found.
[[nodiscard]] std::vector<double> segmented_volume_ml(const Segmentation& segmentation,
                                                      Structure structure);

/// Sets end-diastole and end-systole from the volumes of the LV, or of the heart without one.
void find_ends(Segmentation& segmentation);

}  // namespace beatlas
