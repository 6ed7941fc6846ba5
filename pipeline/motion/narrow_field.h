#pragma once
/// Whether slices show enough of the body beside the heart to tell how they were acquired.

#include <algorithm>

#include "pipeline/core/grid.h"

namespace beatlas::motion {

/// Slices under 100 mm wide along an axis: all that is seen may move, one structure, which has a
/// time of its own, may be all that is seen of the heart, and blocks of tissue are too few to
/// outvote one that is wrong. What is asked of whole slices is not asked of these.
[[nodiscard]] inline bool is_narrow_field(const Grid& grid) {
  constexpr double kLeastMm = 100;
  const Vec3 spacing = grid.spacing_mm();
  return std::min(grid.size[0] * spacing[0], grid.size[1] * spacing[1]) < kLeastMm;
}

}  // namespace beatlas::motion
