#pragma once
/// What a mesh lacks of the surface that it was fitted to.

#include <vector>

#include "pipeline/core/grid.h"
#include "pipeline/mesh/triangle_mesh.h"

namespace beatlas::mesh {

/// Of the zero surface of a phase's samples the share that has no triangle within reach and stands
/// out of the mesh: its vertices may all lie on a surface of which it never entered a part. Pits
/// and slits that it bridges do not count: to enter them costs slivers wherever they are shut.
/// @param distances signed [mm] on `grid`, of cubic voxels
/// @param points, triangles in the grid's frame [mm]
/// @param reach_mm also how far apart the lines lie, along all three axes, on which the surface is
/// looked for
[[nodiscard]] double missed_share(const Grid& grid, const std::vector<float>& distances,
                                  const std::vector<Vec3>& points,
                                  const std::vector<Triangle>& triangles, double reach_mm);

}  // namespace beatlas::mesh
