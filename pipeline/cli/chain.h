#pragma once
/// The stages in a row, as `build` and the stage commands run them: each is given values, gives
/// values and, if there is a study, leaves them in it.

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/cli/console.h"
#include "pipeline/cli/recipe.h"
#include "pipeline/cli/scene.h"
#include "pipeline/core/exam.h"
#include "pipeline/core/shapes.h"
#include "pipeline/report/curves.h"
#include "pipeline/study/stage_files.h"
#include "pipeline/study/study.h"

namespace beatlas::cli {

/// What a package tells of its making beside its payloads.
struct Facts {
  struct StageFact {
    std::string version;
    nlohmann::json options;
  };
  std::map<study::Stage, StageFact> stages;  ///< all but pack
  std::string input_sha256;                  ///< see stack_sha256
  std::string source_format;
  std::vector<std::string> decisions;
  std::vector<std::string> warnings;
  Grid source;  ///< of the stack
  double rr_interval_s = 0;
  std::vector<double> frame_times_s;
  int end_diastole = 0;
  int end_systole = 0;
  std::vector<report::VolumeCurve> volumes;  ///< of the segmentation, in order of structure
  Affine workspace_from_lps = Affine::Identity();
};

class Chain {
 public:
  /// @param study where every stage leaves its values; none: nothing is written
  Chain(Console& console, Recipe recipe, std::optional<study::Study> study);

  [[nodiscard]] const Recipe& recipe() const { return recipe_; }
  [[nodiscard]] study::Study& study() { return *study_; }
  [[nodiscard]] Console& console() { return console_; }

  Exam import(const std::vector<std::filesystem::path>& sources);
  Segmentation segment(const Exam& exam, const std::vector<segment::Seed>& seeds);
  study::Registration registration(const Exam& exam, const Segmentation& segmentation);
  std::vector<FieldCycle> fields(const std::vector<ShapeCycle>& shapes);
  std::vector<SurfaceCycle> surfaces(const std::vector<FieldCycle>& fields);
  /// Volume curves are those of all fields, whatever the scene.
  /// @throws Error{Quality} if the result is below what the recipe demands; nothing is written.
  void pack(const std::vector<FieldCycle>& fields, std::vector<SurfaceCycle> surfaces,
            const Scene& scene, const std::filesystem::path& file);

  /// Takes note, from the study, of the stages up to `last`, which must have run; for a stage
  /// command that starts after it. @throws Error{InvalidInput}
  void recall(study::Stage last);
  /// Takes note, from the study, of all that pack tells of exam, segmentation and workspace.
  void recall_exam();

 private:
  void note(study::Stage stage, nlohmann::json options, const study::FileList& files);
  void note_exam(const Exam& exam);
  void note_segmentation(const Segmentation& segmentation);
  void write_pictures(const Exam& exam, const Segmentation& segmentation);

  Console& console_;
  Recipe recipe_;
  std::optional<study::Study> study_;
  Facts facts_;
};

/// Whether a package of the scene holds any surface, so that the stage mesh must run.
[[nodiscard]] bool scene_has_surfaces(const Scene& scene);

}  // namespace beatlas::cli
