#pragma once
/// Distance fields -> surfaces of all structures beside each other, their levels of detail and
/// maps.

#include <optional>
#include <vector>

#include "pipeline/core/shapes.h"
#include "pipeline/core/stage_context.h"
#include "pipeline/core/surface_map.h"
#include "pipeline/mesh/mesh.h"
#include "pipeline/mesh/surface_map.h"
#include "pipeline/study/study.h"

namespace beatlas::build {

/// One surface a field of the structures that are asked for, in order of the fields. Each follows
/// its own field alone, so that it is the same whichever others are made; where structures share a
/// wall they cross by hundredths of a millimetre, see mesh::part_structures.
/// @throws as mesh::mesh_cycle
[[nodiscard]] std::vector<SurfaceCycle> make_surfaces(const std::vector<FieldCycle>& fields,
                                                      const std::vector<Structure>& of,
                                                      const mesh::MeshOptions& options,
                                                      const StageContext& context);

/// Structures whose surfaces were edited by hand, in any phase.
[[nodiscard]] std::vector<Structure> edited_surfaces(const study::Study& study);

/// The same surfaces with edges of `edge_mm`; those of structures that touch do not cross each
/// other.
/// @param fields of at least the structures that have a surface
/// @param finest what cannot be made is refused; else it is left out, and warned of
/// @throws Error{Quality} for the finest level
[[nodiscard]] std::vector<SurfaceCycle> surfaces_at_level(const std::vector<SurfaceCycle>& made,
                                                          const std::vector<FieldCycle>& fields,
                                                          mesh::MeshOptions options, double edge_mm,
                                                          bool finest, const StageContext& context);

/// Of every surface that has one, in their order; see mesh::surface_map.
[[nodiscard]] std::vector<SurfaceMap> make_maps(const std::vector<FieldCycle>& fields,
                                                const std::vector<SurfaceCycle>& surfaces,
                                                const std::optional<mesh::MapFrame>& frame);

}  // namespace beatlas::build
