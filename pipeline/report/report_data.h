#pragma once
/// What a report shows, as one JSON object that the page draws, and as a small one for programs.

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "pipeline/core/exam.h"
#include "pipeline/core/shapes.h"
#include "pipeline/report/curves.h"
#include "pipeline/report/places.h"
#include "pipeline/report/slice_sheets.h"
#include "pipeline/report/verdict.h"

namespace beatlas::report {

/// One payload of a package.
struct ReportItem {
  std::string what;  ///< "heart, distance" and the like
  std::uint64_t bytes = 0;
  std::string sha256;
  std::string error;  ///< in words; empty: none is known
};

struct ReportPackage {
  std::string scene;
  std::string sha256;
  std::uint64_t bytes = 0;
  std::vector<ReportItem> items;
  /// As its manifest tells them: the segmentation's, before version 6 the distance fields'.
  std::vector<VolumeCurve> volumes;
  std::vector<VolumeCurve> enclosed;  ///< by its own surfaces; none where nobody measured it
  std::optional<double> worst_gap_percent;
  int worst_gap_sign = 0;                  ///< 1 too much, -1 too little, 0 not known
  std::string worst_gap_of;                ///< "the surface of heart in phase 3"
  std::size_t checks = 0;                  ///< that it was put to without the truth
  std::vector<std::string> failed_checks;  ///< a sentence each
};

/// A stage that ran, for the record.
struct ReportStage {
  std::string name;
  std::string version;
  std::string state;  ///< as `status` tells it
  nlohmann::json options = nlohmann::json::object();
  std::vector<std::string> edited;
  std::vector<std::string> warnings;  ///< what it said when it ran
  std::optional<double> wall_s;       ///< if it ran just now
};

/// How near the true surface of a structure lies at end-diastole, with 90 %.
struct KnownSurface {
  Structure structure{};
  double in_slices_mm = 0;  ///< median over the slices that it is labelled in, within their planes
  int worst_slice = 0;
  double worst_slice_mm = 0;
  double at_base_mm = 0;  ///< where it lies flat in the slices: at its last one toward the base
  double at_apex_mm = 0;  ///< the same toward the apex
};

/// What is there of a study, or of a package without one; all but the exam may be missing.
struct ReportInput {
  bool is_study = true;    ///< that can be corrected and built again
  bool has_images = true;  ///< else the exam's are black
  const Exam* exam = nullptr;
  const Segmentation* segmentation = nullptr;
  std::vector<VolumeCurve> volumes;  ///< of a package without its study; else the segmentation's
  BoundaryUncertainty uncertainty;
  std::vector<KnownSurface> known;  ///< told of labels that grew as is_fitted_to asks
  std::vector<SurfaceCycle> surfaces;
  std::vector<SurfaceFigures> surface_figures;
  std::optional<Affine> workspace_from_lps;
  std::optional<ReportPackage> package;
  std::string refused;            ///< why no package was written
  std::vector<Structure> needed;  ///< by the scene
  bool has_made_package = false;  ///< at any time, so that `build` knows where to write it
  std::vector<ReportStage> stages;
  std::string input_sha256;
  std::string program;    ///< name and version
  std::string made_from;  ///< hash of all that the report shows
  std::size_t drawn_seeds = 0;
  std::set<int> given_phases;  ///< whose labels came from elsewhere: they stay as they are
  nlohmann::json self_test = nlohmann::json::value_t::null;  ///< see schemas/assess.schema.json
  nlohmann::json before = nlohmann::json::value_t::null;  ///< report_summary of the build before,
                                                          ///< null if there was none
};

/// For programs: verdict, reasons, figures, alarms; see schemas/report.schema.json. No text of a
/// patient, no path, no clock.
[[nodiscard]] nlohmann::json report_summary(const ReportInput& input);

/// For the page: the summary and all that is drawn, see page/report.js.
[[nodiscard]] nlohmann::json report_json(const ReportInput& input);

/// The page with its data: one file that needs no other and no network.
[[nodiscard]] std::string report_html(const nlohmann::json& report);

/// The commands that correct what is wrong at a place, to be run in the study's folder: a seed that
/// pushes a leak back, with LABEL for what only an eye finds where labels do not tell it; then the
/// build.
/// @param drawn the labels were painted or given: they are kept, whatever is seeded, and only the
/// build is left once they were corrected
[[nodiscard]] std::vector<std::string> correcting_commands(const Place& place, bool drawn,
                                                           bool has_made_package = true);

/// How to get structures that were not found: what to do, and the commands, to be run in the
/// study's folder, with X,Y,Z for a place that only an eye finds.
/// @param phase in which they are to be marked
/// @param drawn as above
struct WaysToFind {
  std::string how;
  std::vector<std::string> commands;
};
[[nodiscard]] WaysToFind ways_to_find(const std::vector<Structure>& missing, int phase, bool drawn,
                                      bool has_made_package);

}  // namespace beatlas::report
