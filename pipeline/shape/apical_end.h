#pragma once
/// Where shapes close beyond the slice nearest to the apex. Between slices far apart no image shows
/// it, and where the stack ends none can; but a ventricle tapers, and muscle closes it.

#include <cstddef>
#include <optional>
#include <vector>

#include "pipeline/core/shapes.h"

namespace beatlas::shape {

/// Area of the section of slice k, in voxels of `grid`; 0 where none of them is half covered.
[[nodiscard]] double section_voxels(const Grid& grid, const std::vector<float>& coverage, int k);

/// Whether there are both the LV's blood and its muscle.
[[nodiscard]] bool holds_lv(const CoverageCycle& coverage);

/// Coverage of one phase of the LV's blood and muscle together. @pre there are both
[[nodiscard]] std::vector<float> filled_lv(const CoverageCycle& coverage, std::size_t phase);

/// Beyond its most apical slice a structure closes roundly.
struct ApicalEnd {
  int step = 0;       ///< of the slice index, toward the apex; 0: unknown
  double gaps = 0.5;  ///< from the centre of the structure's last slice to where it closes
};

/// Step toward the apex: from the LV's cut at the base, else from the axis where it runs across the
/// slices, else 0.
[[nodiscard]] int step_to_apex(const Segmentation& segmentation,
                               const std::optional<LongAxis>& axis);

/// Of a structure in one phase.
struct ApicalEnds {
  ApicalEnd wall;    ///< of the structure; of LV blood and muscle together for these two
  ApicalEnd cavity;  ///< of LV blood, for these two
};

/// The section of a rounded end grows as the distance from its tip, so the last two sections tell
/// it: at most a gap away, half a gap where the stack ends. A cavity whose last slice is the wall's
/// stays half of that slice's wall short of the wall's end, for a ventricle is thinnest at its
/// apex. The heart does not end before its LV.
/// @param step towards the apex; 0: half a gap
[[nodiscard]] ApicalEnds apical_ends(const Segmentation& segmentation, Structure structure,
                                     std::size_t phase, int step);

/// Slice index in the source's grid, fractional, at which the LV's wall closes, where it does so
/// beyond the stack; none elsewhere.
[[nodiscard]] std::optional<double> lv_apex_k(const Segmentation& segmentation, std::size_t phase,
                                              int step);

/// How many gaps between slices beyond the stack's last slice towards the apex the LV would close,
/// as its sections shrink; infinite where they do not, 0 where it closes within the stack.
/// @param step towards the apex, not 0
[[nodiscard]] double lv_gaps_beyond(const Segmentation& segmentation, std::size_t phase, int step);

}  // namespace beatlas::shape
