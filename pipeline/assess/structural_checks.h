#pragma once
/// What can be said of a package without knowing the truth.

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "pipeline/core/stage_context.h"
#include "runtime/atlas/atlas.h"
#include "runtime/field/field_query.h"

namespace beatlas::assess {

/// One figure of one structure, or of the package, against its limit.
struct Check {
  std::string structure;  ///< "package" if it concerns no single structure
  std::string name;
  double worst = 0;  ///< over all phases
  double limit = 0;
  [[nodiscard]] bool passed() const { return worst <= limit; }
};

/// Limits are of damage and mix-up, not of accuracy.
struct StructuralLimits {
  /// Of field or surface against the package's volume curve, as a share of its largest volume.
  double volume_gap_percent = 20;
  double vertex_distance_voxels = 1.0;  ///< RMS of a surface's vertices in its structure's field
  double wrong_side_percent = 5;
  double crossing_percent = 1;         ///< of a surface with itself
  double nested_crossing_percent = 1;  ///< between two structures; before version 5 any
  double stray_percent = 1;
  double slope_error = 0.5;  ///< of |grad phi| = 1
  /// Mean distance of a surface's triangles from its structure's field, for edges of 4 mm and less;
  /// beyond, it may grow with the square of their length, as what edges cut off does.
  double surface_error_mm = 0.3;
  double wrap_step_ratio = 1.5;  ///< the cycle closes with no larger step than it has elsewhere
};

/// Of the package:
/// - `content`: payloads that its scene holds and it lacks, or that it holds beyond its scene; 0;
/// - `end_phases`: end diastole and end systole that are no extremes of the LV's volume; 0;
/// - `missing_phases` of each structure that the provenance's `needs` names: where it is not; 0;
/// - `impossible_ef_points` of the LV: see possible_heart.h; 0.
/// For every surface `open_edges` and `pinched_vertices` (both 0: a closed 2-manifold),
/// `crossing_percent` (pairs that cut each other, of the triangles), `surface_volume_gap_percent`
/// and `wrap_step_ratio`; for every field `field_volume_gap_percent`, `stray_percent` and
/// `slope_error`; where both are there `vertex_distance_mm`, `surface_error_mm` and
/// `wrong_side_percent`; once more for each coarser level of detail, as `open_edges_level_1`. For
/// every two structures with a surface `crosses_NAME`: pairs that cut each other, of the triangles
/// of the former; since version 5. See surface_checks.h and field_checks.h. The
/// package was already checked byte by byte, sizes and hashes, when it was opened.
[[nodiscard]] std::vector<Check> check_structure(const atlas::Atlas& package,
                                                 const StructuralLimits& limits,
                                                 StageContext& context);

/// What check_structure does for one structure; null where the package does not hold it.
/// @param edge_mm of the surface's triangles, 0 if untold
[[nodiscard]] std::vector<Check> check_one(const atlas::StructureEntry& entry,
                                           const atlas::SurfacePayload* surface,
                                           const field::FieldQuery* query,
                                           const StructuralLimits& limits, double edge_mm = 0);
/// And for the manifest.
[[nodiscard]] std::vector<Check> check_manifest(const atlas::Manifest& manifest);

/// What did not pass, a sentence each. `validate` passes a package, and `build` calls one good,
/// only where there is nothing of it.
[[nodiscard]] std::vector<std::string> failures_of(const std::vector<Check>& checks);

/// {"checks": [{"structure", "name", "worst", "limit", "passed"}], "failures", "passed"}
[[nodiscard]] nlohmann::json checks_to_json(const std::vector<Check>& checks);
[[nodiscard]] std::string checks_to_text(const std::vector<Check>& checks);
[[nodiscard]] bool all_passed(const std::vector<Check>& checks);

}  // namespace beatlas::assess
