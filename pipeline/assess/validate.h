#pragma once
/// A package against the closed-form truth of the phantom it was made from: what a user of the
/// package would feel, so its field is asked as the runtime asks it.

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "pipeline/core/stage_context.h"
#include "pipeline/phantom/phantom.h"
#include "runtime/atlas/atlas.h"

namespace beatlas::assess {

/// Limits that make `passed`; those not set do not count. Each holds in every phase of every
/// structure.
struct ValidateLimits {
  std::optional<double> max_mean_mm;
  std::optional<double> max_p95_mm;
  std::optional<double> max_hausdorff_mm;
  std::optional<double> max_bias_mm;  ///< of the magnitude
  std::optional<double> min_dice;
  std::optional<double> max_volume_error_ml;          ///< of the magnitude
  std::optional<double> max_ejection_fraction_error;  ///< of the magnitude, as a share: 0.03

  double crease_band_mm = 2.0;     ///< around creases of the truth no surface distance is taken
  double sample_spacing_mm = 2.0;  ///< [mm] 0.3..20: between points on the true surface
};

/// One structure in one phase.
struct PhaseErrors {
  double dice = 0;             ///< 0..1, voxels of the source's grid by their centres
  double volume_error_ml = 0;  ///< the package's volume curve minus the truth
  // Distances between the surfaces, both ways: points of the package's zero level to the exact
  // truth, points of the true surface to the package's field; each way has half of the weight.
  double mean_mm = 0;
  double p95_mm = 0;
  double hausdorff_mm = 0;
  double bias_mm = 0;  ///< signed mean, + where the package is larger
  int points = 0;      ///< points of both ways
};

struct StructureErrors {
  Structure structure{};
  std::vector<PhaseErrors> phases;
  /// Of the package's curve minus that of the truth; only for lv_blood and rv_blood.
  std::optional<double> ejection_fraction_error;
};

struct ValidationReport {
  std::vector<StructureErrors> structures;
  bool passed = false;
  std::vector<std::string> failures;  ///< one sentence each; empty if passed
};

/// Every structure of the package whose field was opened. Without limits `passed` says that each
/// has a surface in every phase that overlaps the truth.
/// @throws Error{InvalidInput} if the package was not made from images of this phantom (its source
/// grid, number of frames or R-R interval are others), or none of its fields was opened.
[[nodiscard]] ValidationReport validate(const atlas::Atlas& atlas, const phantom::Phantom& truth,
                                        const ValidateLimits& limits, StageContext& context);

/// What `validate` needs of an opened package: for tests and for fields not yet packed.
struct Candidate {
  atlas::Manifest manifest;
  std::vector<std::shared_ptr<const atlas::FieldPayload>> fields;
};
[[nodiscard]] ValidationReport validate(const Candidate& candidate, const phantom::Phantom& truth,
                                        const ValidateLimits& limits, StageContext& context);

/// {"structures": [{"name", "phases": [{"dice", "volume_error_ml", "mean_mm", "p95_mm",
/// "hausdorff_mm", "bias_mm", "points"}], "ejection_fraction_error"?}], "passed", "failures"}.
[[nodiscard]] nlohmann::json report_to_json(const ValidationReport& report);

}  // namespace beatlas::assess
