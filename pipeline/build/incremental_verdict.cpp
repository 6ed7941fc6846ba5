// What a study must be so that a package is made of it: asked with the report's own words, so that
// no package is left that the report calls rejected.

#include <algorithm>
#include <vector>

#include "pipeline/assess/surface_checks.h"
#include "pipeline/build/incremental_build.h"
#include "pipeline/build/made_package.h"
#include "pipeline/core/words.h"
#include "pipeline/report/report_data.h"
#include "pipeline/report/verdict.h"
#include "pipeline/study/state.h"
#include "runtime/base/error.h"

namespace beatlas::build {
namespace fs = std::filesystem;
using study::Stage;
namespace {

/// A command of the report, which is run in the study's folder, as it is run from here.
std::string run_from_here(std::string command, const fs::path& folder) {
  const std::size_t at = command.find(" . ");
  return at == std::string::npos ? command
                                 : command.replace(at + 1, 1, shell_word(folder.string()));
}

}  // namespace

std::vector<Structure> IncrementalBuild::needed(const Scene& scene) {
  if (!orders_.labels) return structures_needed(scene, false);
  const std::vector<int>& named = orders_.labels->phases;
  if (named.empty()) return structures_needed(scene, true);
  if (!exam_noted_) (void)exam();
  return structures_needed(scene, static_cast<int>(named.size()) == facts_.phases);
}

Scene IncrementalBuild::told_scene() const {
  if (scene_) return *scene_;
  const study::StageRecord* record = study_ ? study_->find(Stage::Pack) : nullptr;
  return record != nullptr && record->options.contains("scene") ? made_scene(*study_) : Scene();
}

void IncrementalBuild::demand_heart(const Scene& scene, const fs::path& file) {
  scene_ = scene;
  if (is_packed(wanted_pack(scene), file)) return;
  (void)segmentation();
  demand_usable(scene, {});
}

void IncrementalBuild::demand_usable(const Scene& scene,
                                     const std::vector<SurfaceCycle>& surfaces) {
  report::VerdictInput asked;
  asked.segmented = true;
  asked.segmentation = report::heart_figures(facts_.volumes);
  asked.missing = report::missing_structures(facts_.volumes, needed(scene));
  for (const SurfaceCycle& surface : surfaces) {
    // Triangles that cut others only ask for a look.
    asked.surfaces.push_back({surface.structure,
                              static_cast<double>(assess::open_edges(surface.triangles)),
                              static_cast<double>(assess::pinched_vertices(surface.triangles)), 0});
  }
  const std::vector<std::string> reasons = report::rejections(report::findings(asked));
  if (reasons.empty()) return;
  std::string said;
  for (const std::string& reason : reasons) said += (said.empty() ? "" : "; ") + reason;
  note_refusal(Stage::Pack, said);  // without the study's own place, which the words below name
  said += "; no package was written";
  if (asked.missing.empty()) throw Error(ErrorCode::Quality, said);
  if (!study_) {
    throw Error(ErrorCode::Quality,
                said + "; build with --study DIR, whose report tells how to mark what is missing");
  }
  // Labels that somebody drew stay, whatever is seeded.
  const std::vector<int> given = orders_.labels ? orders_.labels->phases : std::vector<int>{-1};
  const bool drawn = !study::edited_outputs(*study_, Stage::Segment).empty() || given.empty() ||
                     std::find(given.begin(), given.end(), facts_.end_diastole) != given.end();
  const report::WaysToFind ways =
      report::ways_to_find(asked.missing, facts_.end_diastole, drawn, true);
  throw Error(
      ErrorCode::Quality,
      said + (drawn ? "; paint it in segment/labels.nii.gz of the study"
                    : "; mark it: " + run_from_here(ways.commands.front(), study_->folder())));
}

}  // namespace beatlas::build
