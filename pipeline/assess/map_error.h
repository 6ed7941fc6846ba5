#pragma once
#include "pipeline/assess/figures.h"
#include "pipeline/phantom/phantom.h"
#include "runtime/atlas/payloads.h"

namespace beatlas::assess {

struct MapOptions {
  /// >= 0 [mm]: thickness counts where both ends of the true wall keep this far from the creases of
  /// the true muscle (the rim of the base), as ThicknessOptions::rim_mm.
  double rim_mm = 4.0;
  double off_wall_mm = 3.0;  ///< > 0 [mm]: a vertex farther than this from the true wall has none
  int most_vertices = 2000;  ///< 1..1000000: asked a phase, evenly taken
};

/// Wall thickness and AHA segments of a surface's map against the closed form, in every phase and
/// the first.
///
/// Thickness, at the point of the true surface nearest to a vertex: on the endocardium the length
/// of muscle along its normal, on the epicardium the distance to the endocardium. Segment: of the
/// vertex's own place between the wall's apical end and the base plane and about the long axis, the
/// middle of the septum towards the RV, by thirds of the length and sectors of 60 (apical: 90)
/// degrees; the lowest 8 % are the apex. Asked where the map has a wall. On the RV's endocardium
/// thickness is the length of its free wall along the normal, and nothing has a segment.
/// @param map, surface of one structure, lv_blood, lv_myocardium or rv_blood, vertex by vertex
[[nodiscard]] MapErrors map_errors(const atlas::SurfaceMapPayload& map,
                                   const atlas::SurfacePayload& surface,
                                   const Affine& workspace_from_lps, const phantom::Phantom& truth,
                                   const MapOptions& options);

}  // namespace beatlas::assess
