#pragma once
/// A package against the closed-form truth of the phantom it was made from: what a user of the
/// package would feel, so its field is asked as the runtime asks it.

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "pipeline/assess/compare.h"
#include "pipeline/assess/figures.h"
#include "pipeline/assess/map_error.h"
#include "pipeline/assess/motion_error.h"
#include "pipeline/assess/palpation_set.h"
#include "pipeline/assess/promises.h"
#include "pipeline/assess/wall_thickness.h"
#include "pipeline/core/stage_context.h"
#include "pipeline/phantom/drawn_truth.h"
#include "pipeline/phantom/phantom.h"
#include "runtime/atlas/atlas.h"

namespace beatlas::assess {

struct ValidateOptions {
  LimitSet limits;                       ///< that make `passed`
  const PromiseSet* promises = nullptr;  ///< held to beside them; null: none
  CompareOptions compare;
  ThicknessOptions thickness;
  MotionOptions motion;
  MapOptions map;
  /// Of the force; palpations.structure is felt.
  PalpationOptions palpations;
  double stiffness_n_per_m = 150;  ///< [N/m] 1..5000
  /// Whether a package without the field of palpations.structure is refused; if not, it has no
  /// figures of force.
  bool demand_force = false;
};

struct StructureErrors {
  Structure structure{};
  std::vector<PhaseErrors> phases;
  /// Of each phase; only for lv_myocardium, and only where the field of lv_blood is there too.
  std::vector<ThicknessErrors> wall_thickness;
  /// Only where its surface was opened too and has vertices on the LV's wall.
  std::optional<MotionErrors> motion;
  /// Only where its surface and the map of that were opened.
  std::optional<MapErrors> map;
  /// Of the package's curve minus that of the truth; only for lv_blood and rv_blood.
  std::optional<double> ejection_fraction_error;
};

/// Of a structure by its surface alone; see drawn_errors.h.
struct DrawnStructure {
  Structure structure{};
  std::vector<DrawnErrors> phases;  ///< empty: the truth has no such part
  /// At end-diastole and end-systole, by the phase; only of a drawn exam's truth.
  std::map<int, std::vector<VertexError>> vertices;
  /// [%] Of the area of `vertices`, what lies within its band (atlas::BandQuery), of which 90
  /// should; none where the package tells no band.
  std::optional<double> band_percent;
};

struct FeltErrors {
  Structure structure{};
  double stiffness_n_per_m = 0;
  ForceErrors errors;
};

struct ValidationReport {
  std::vector<StructureErrors> structures;
  std::vector<DrawnStructure> drawn;
  std::optional<FeltErrors> force;
  std::string_view held_to = "none";  ///< name of the promises
  bool passed = false;
  /// One sentence each, with structure, phase, figure and limit; empty if passed.
  std::vector<std::string> failures;
};

/// What `validate` needs of an opened package: for tests and for fields not yet packed.
struct Candidate {
  atlas::Manifest manifest;
  std::vector<std::shared_ptr<const atlas::FieldPayload>> fields;
  std::vector<std::shared_ptr<const atlas::SurfacePayload>> surfaces = {};
  std::vector<std::shared_ptr<const atlas::SurfaceMapPayload>> maps = {};
};
[[nodiscard]] Candidate candidate_of(const atlas::Atlas& atlas);

/// Every structure of the package whose field was opened, or whose surface alone was. Without
/// limits `passed` says that each has a surface in every phase that overlaps the truth.
/// @throws Error{InvalidInput} if the package was not made from images of this phantom (see
/// same_phantom.h), none of its fields was opened, or an option is out of range.
[[nodiscard]] ValidationReport validate(const Candidate& candidate, const phantom::Phantom& truth,
                                        const ValidateOptions& options, StageContext& context);

/// Of the package of a drawn exam: every structure by its surface, in `drawn` alone; limits of
/// distance and volume hold for those of the ventricles and the heart.
/// @throws Error{InvalidInput} if the package was not made from the images of this draw, has other
/// phases or no surface, or an option is out of range.
[[nodiscard]] ValidationReport validate(const Candidate& candidate,
                                        const phantom::DrawnTruth& truth,
                                        const ValidateOptions& options, StageContext& context);

/// Appends to report.failures what breaks a limit, and sets `passed`.
void judge(const LimitSet& limits, ValidationReport& report);

/// Appends what is worse than kPromiseMargin times what is promised, of those structures that the
/// package holds, and of the force where it is the heart's; sets `passed` and `held_to`.
void hold_to(const PromiseSet& promises, ValidationReport& report);

/// {"structures": [{"name", "phases": [{figures of kPhaseFigures, "points", "wall_thickness"?:
/// {figures of kThicknessFigures, "points", "missing"}}], "motion"?: {figures of kMotionFigures,
/// "points"}, "map"?: {figures of kMapFigures and kSegmentFigures, "points", "missing", "named"},
/// "ejection_fraction_error"?}], "drawn": [{"name", "phases": [{figures of kDrawnFigures,
/// "points"}], "band_percent"?}],
/// "force"?: {"structure", "stiffness_n_per_m", figures of kForceFigures, "ticks", ...}, "held_to",
/// "passed", "failures"}. See schemas/validate.schema.json.
[[nodiscard]] nlohmann::json report_to_json(const ValidationReport& report);

}  // namespace beatlas::assess
