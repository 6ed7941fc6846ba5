#pragma once
#include <vector>

#include "pipeline/core/shapes.h"

namespace beatlas {

/// Volume [ml] of a structure in every phase: its coverage, each slice as thick as slices are
/// apart. Empty if the structure was not found.
[[nodiscard]] std::vector<double> segmented_volume_ml(const Segmentation& segmentation,
                                                      Structure structure);

}  // namespace beatlas
