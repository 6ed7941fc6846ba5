#pragma once
#include <optional>
#include <vector>

#include "pipeline/core/shapes.h"
#include "pipeline/core/stage_context.h"

namespace beatlas::mesh {

struct MeshOptions {
  /// [mm] 0.5..10: target edge length; none: see triangle_edge_mm.
  std::optional<double> edge_mm = {};
  /// Phase that is meshed and remeshed; the others follow it. -1: the first or, where its triangles
  /// do not come through the cycle sound, one of three others from which they do better.
  int reference_phase = -1;
};

/// [mm] Target edge length of the triangles of a field's surface: that of the options or, where
/// they name none, 10/9 of the field's samples, from 2 to 10. Edges of 2 lie 0.005 mm from the
/// field on average; 4 lie 0.012 mm off for a third of the bytes, 1.5 take twice the bytes for
/// 0.004 mm (`beatlas bench`, small). Edges much longer than samples miss pockets: of 4/3 the RV's
/// surface of cine-exam lies 0.32 mm off in the mean, of 10/9 0.24 (limit of `validate`: 0.3).
[[nodiscard]] double triangle_edge_mm(double voxel_mm, const MeshOptions& options);

/// One closed surface a phase with one connectivity: the reference phase is meshed (marching
/// tetrahedra of the distance), remeshed (CGAL), carried from phase to phase by the field, and put
/// on each phase's zero surface. Of several components the one that encloses most is kept and the
/// rest is named in the log, as are handles (field/repair_topology.h leaves neither) and a phase
/// whose vertices are more than 0.05 mm off its surface on average. Vertices move along the surface
/// only as far as keeps the motion smooth over the mesh: the images say nothing about true
/// tangential motion (twist).
/// @throws Error{Usage} for options out of range; Error{InvalidInput} if a phase has no surface;
/// Error{Quality} if the surface cannot be made a closed manifold.
[[nodiscard]] SurfaceCycle mesh_cycle(const FieldCycle& field, const MeshOptions& options,
                                      StageContext& context);

/// @throws Error{Usage} for options out of range; Error{InvalidInput} if there is no phase
void check_options(const FieldCycle& field, const MeshOptions& options);

/// Figures of one phase of a surface.
struct PhaseQuality {
  double least_angle_deg = 0;         ///< smallest corner of any triangle
  double percentile_1_angle_deg = 0;  ///< 1 % of the triangles have a smaller least corner
  int flipped_triangles = 0;          ///< normal against the mean normal at the three vertices
  int self_intersections = 0;         ///< pairs of triangles that cross (CGAL, exact predicates)
  double volume_ml = 0;               ///< enclosed, positive if triangles face outward
  double mean_edge_mm = 0;
};

struct MeshQuality {
  bool closed_manifold =
      false;             ///< every edge has two faces, every vertex one fan, one orientation
  int euler_number = 0;  ///< V - E + F: 2 for a sphere, 0 with one handle
  std::vector<PhaseQuality> phases;
  /// Root mean square over vertices and phases of what lies beyond a third of the phases in the
  /// harmonics of their ways: hardly motion, nearly all of it jitter. Along the surface and across.
  double tangential_jitter_mm = 0;
  double normal_jitter_mm = 0;
};

/// The phases' figures are all 0 where the surface is no closed manifold.
[[nodiscard]] MeshQuality measure_quality(const SurfaceCycle& surface);

}  // namespace beatlas::mesh
