#pragma once
#include <vector>

#include "pipeline/core/shapes.h"
#include "pipeline/field/surface.h"

namespace beatlas::field {

/// Where the rows of a grid along i run through a closed surface: [j + size_j * k], ascending, in
/// voxels. A voxel's centre is inside if an odd number of them lies at or before it. Rows run a
/// hair beside the centres, so that none meets a corner or an edge.
[[nodiscard]] std::vector<std::vector<double>> row_crossings(const TriangleSoup& surface,
                                                             const Grid& grid);

}  // namespace beatlas::field
