#pragma once
/// Levels of detail: the same moving surface in larger or smaller triangles.

#include "pipeline/core/shapes.h"
#include "pipeline/core/stage_context.h"
#include "pipeline/mesh/mesh.h"

namespace beatlas::mesh {

/// `surface` in triangles of about options.edge_mm: its reference phase is remeshed (CGAL, Botsch
/// and Kobbelt 2004); each new vertex keeps its place in the old triangle that it lies on, so that
/// it goes with the same muscle, and is put on the field's zero surface in every phase, evened out
/// and mended as in mesh_cycle. So a level has one connectivity for the cycle, is a closed
/// 2-manifold of the genus of `surface`, and lies on the field where `surface` does. The same bits
/// for any number of threads.
/// @param surface of mesh_cycle  @param field it was made from
/// @param options edge_mm of the level; reference_phase, -1: the first
/// @throws Error{Usage} for options out of range; Error{InvalidInput} if field and surface are of
/// different phases; Error{Quality} if the structure is too small for such triangles.
[[nodiscard]] SurfaceCycle level_of_detail(const SurfaceCycle& surface, const FieldCycle& field,
                                           const MeshOptions& options, StageContext& context);

/// How far a surface lies from the zero of its field: at the middle of each triangle and half-way
/// from there to its corners, by area, so that what edges cut off counts.
struct SurfaceError {
  double mean_mm = 0;         ///< of magnitudes, all phases
  double worst_phase_mm = 0;  ///< the same of the worst phase
  double bias_mm = 0;         ///< signed, + where the surface is outside, all phases
};
/// @throws Error{InvalidInput} if field and surface are of different phases.
[[nodiscard]] SurfaceError error_against(const FieldCycle& field, const SurfaceCycle& surface);

}  // namespace beatlas::mesh
