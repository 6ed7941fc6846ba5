#pragma once
/// How a structure's sections lie beside each other, slice after slice.

#include <vector>

#include <Eigen/Core>

#include "pipeline/core/grid.h"

namespace beatlas::shape {

using SectionPath = std::vector<Eigen::Vector2d>;  ///< [slice] a place in its plane [index]

/// A place in each slice: moved by the difference of two, the sections of neighbours cover each
/// other best, all phases together, by the shortest way that does nearly as well. Between slices
/// far apart a section goes along this path (Herman, Zheng and Bucholtz, "Shape-based
/// interpolation", IEEE CG&A 12(3), 1992): interpolated in place, sections of a thin or leaning
/// body that do not lie over each other would come apart. A step is no longer than the gap between
/// slices, a lean of 45 degrees; to slices without a section there is none.
/// @param phases coverage of the structure on `grid`
[[nodiscard]] SectionPath section_path(const Grid& grid,
                                       const std::vector<std::vector<float>>& phases);

}  // namespace beatlas::shape
