#pragma once
#include "pipeline/core/shapes.h"
#include "pipeline/core/stage_context.h"

namespace beatlas::mesh {

struct MeshOptions {
  double edge_mm = 2.0;     ///< [mm] 0.5..10: target edge length
  int reference_phase = 0;  ///< phase that is meshed and remeshed; the others follow it
};

/// One closed surface a phase with one connectivity: the reference phase is meshed (OpenVDB's
/// distance), remeshed (CGAL), carried from phase to phase by the field and smoothed (OpenMesh).
/// @throws Error{InvalidInput} if a phase has no surface; Error{Quality} if the surface cannot be
/// made a closed manifold.
[[nodiscard]] SurfaceCycle mesh_cycle(const FieldCycle& field, const MeshOptions& options,
                                      StageContext& context);

}  // namespace beatlas::mesh
