#pragma once
/// What must hold of a distance field that beats, whatever it shows.

#include <vector>

#include "runtime/atlas/payloads.h"
#include "runtime/field/field_query.h"

namespace beatlas::assess {

/// What the lattice of a field says of one phase.
struct PhaseOfField {
  /// Every sample counts by how much of its voxel lies inside, for a surface that crosses it
  /// straight [ml].
  double volume_ml = 0;
  /// Islands beside the largest piece inside, and holes that the outside does not reach, of the
  /// volume inside [%]; 0 where nothing is inside.
  double stray_percent = 0;
  /// 95th percentile of | |grad phi| - 1 | over the samples within half a voxel of the surface.
  double slope_error = 0;
};

/// One entry a phase.
[[nodiscard]] std::vector<PhaseOfField> look_at_phases(const atlas::FieldPayload& field);

/// Largest RMS over the phases of the distance that the field has at a surface's vertices [mm].
[[nodiscard]] double vertex_distance_mm(const field::FieldQuery& query,
                                        const atlas::SurfacePayload& surface);

/// Largest mean over the phases of the field's |distance| at the middles of a surface's triangles
/// and half-way from there to their corners, by area [mm].
[[nodiscard]] double surface_error_mm(const field::FieldQuery& query,
                                      const atlas::SurfacePayload& surface);

/// Vertices from which a step of a voxel along the surface's own normal does not lead outside, or
/// against it not inside, of all [%]; of the worst phase.
[[nodiscard]] double wrong_side_percent(const field::FieldQuery& query,
                                        const atlas::SurfacePayload& surface);

}  // namespace beatlas::assess
