#pragma once
#include <vector>

#include "pipeline/core/shapes.h"

namespace beatlas {

/// The share 0..1 of slice k (index in the source's grid, it covers k - 0.5 to k + 0.5) on the
/// structure's side of its cut in one phase; 1 for a structure without one.
[[nodiscard]] double share_within_cut(const Segmentation& segmentation, Structure structure,
                                      int phase, int k);

/// Volume [ml] of a structure in every phase: its coverage, without what lies beyond its cut.
/// Empty if the structure was not found.
[[nodiscard]] std::vector<double> segmented_volume_ml(const Segmentation& segmentation,
                                                      Structure structure);

}  // namespace beatlas
