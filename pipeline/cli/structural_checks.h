#pragma once
/// What can be said of a package without knowing the truth.

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "pipeline/core/stage_context.h"
#include "runtime/atlas/atlas.h"

namespace beatlas::cli {

/// One figure of one structure against its limit.
struct Check {
  std::string structure;
  std::string name;
  double worst = 0;  ///< over all phases
  double limit = 0;
  [[nodiscard]] bool passed() const { return worst <= limit; }
};

/// Limits are of damage and mix-up, not of accuracy.
struct StructuralLimits {
  double volume_gap_percent = 20;  ///< of field or surface against the package's volume curve
  double vertex_distance_voxels =
      1.0;  ///< RMS of a surface's vertices in the field of its structure
};

/// For every surface: `open_edges` (directed edges without exactly one opposite; 0) and
/// `surface_volume_gap_percent`; for every field `field_volume_gap_percent`; where both are there
/// `vertex_distance_mm`, the RMS distance of the vertices in the field. The package was already
/// checked byte by byte when it was opened.
[[nodiscard]] std::vector<Check> check_structure(const atlas::Atlas& package,
                                                 const StructuralLimits& limits,
                                                 StageContext& context);

/// {"checks": [{"structure", "name", "worst", "limit", "passed"}], "passed"}
[[nodiscard]] nlohmann::json checks_to_json(const std::vector<Check>& checks);
[[nodiscard]] std::string checks_to_text(const std::vector<Check>& checks);
[[nodiscard]] bool all_passed(const std::vector<Check>& checks);

}  // namespace beatlas::cli
