#pragma once
#include <optional>

#include "pipeline/core/shapes.h"

namespace beatlas::shape {

/// [mm] How thick the LV's wall is: the median, over slices and phases that hold blood and muscle
/// of the LV, of the width of the ring that has their areas. None without such a slice.
[[nodiscard]] std::optional<double> wall_thickness_mm(const CoverageCycle& coverage);

}  // namespace beatlas::shape
