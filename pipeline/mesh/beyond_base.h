#pragma once
/// Atria and vessels, which begin where ventricles end.

#include <vector>

#include "pipeline/core/shapes.h"

namespace beatlas::mesh {

/// What lies beyond the base as it is to be meshed: without the ventricles, their muscle and a gap
/// around them, max(phi, gap - phi_ventricle). Two fields of a valve that both is in lie up to a
/// voxel into each other; a mesh that is made where they do not has nothing to be moved out of.
/// Distances are exact but beyond the crease where both surfaces meet, where they are too short.
/// @param field of a structure beyond the base @param all of the same phases
/// @param edge_mm of the triangles: the longer, the farther they cut across a curved valve
[[nodiscard]] FieldCycle without_ventricles(const FieldCycle& field,
                                            const std::vector<FieldCycle>& all, double edge_mm);

}  // namespace beatlas::mesh
