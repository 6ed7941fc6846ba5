#pragma once
/// The stages in a row, as `build` and the stage commands run them. Each call brings one stage up
/// to date: it runs the stage, or keeps what the study holds if that is what it would make, or if
/// it was edited by hand. Values pass in memory; what was kept is read when a later stage asks.

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/assess/self_test.h"
#include "pipeline/build/facts.h"
#include "pipeline/build/heart_images.h"
#include "pipeline/build/listener.h"
#include "pipeline/build/orders.h"
#include "pipeline/build/scene_plan.h"
#include "pipeline/core/exam.h"
#include "pipeline/core/shapes.h"
#include "pipeline/core/surface_map.h"
#include "pipeline/pack/pack.h"
#include "pipeline/study/stage_files.h"
#include "pipeline/study/state.h"
#include "pipeline/study/study.h"

namespace beatlas::report {
struct ReportInput;
}

namespace beatlas::build {

class IncrementalBuild {
 public:
  static constexpr double kMade = 0.95;  ///< of a stage, when all is made and not yet written

  /// @param study where every stage leaves its values; none: nothing is written
  IncrementalBuild(Listener& listener, Orders orders, std::optional<study::Study> study);

  /// @param sources none: what the study holds is kept
  void import(const std::vector<std::filesystem::path>& sources);
  /// An exam that was made, not read; @param files it was made from, of which a study keeps the
  /// hash
  void import_made(Exam exam, const std::vector<std::filesystem::path>& files);
  /// What was imported -> the package of a scene: all that follows, in order, by the scene's plan.
  /// @throws as the stages
  void make(const Scene& scene, const std::filesystem::path& file);

  /// Also brings the pictures up to date.
  void segment();
  void registration();
  void fields();
  void surfaces();
  /// Refuses at once, before surfaces and fields are made, what `pack` would refuse by the
  /// segmentation alone. @throws Error{Quality}
  void demand_heart(const Scene& scene, const std::filesystem::path& file);
  /// What the report calls rejected is refused.
  /// @throws Error{Quality} if the result is below what the recipe demands; nothing is written.
  void pack(const Scene& scene, const std::filesystem::path& file);

  /// How well the exam's slices and phases foretell each other. The study keeps it for its report.
  /// @pre a study  @throws as assess::self_test
  assess::SelfTest self_test();

  /// @pre a study. Writes its report: the page, and report.json into the study; gives the latter
  /// and says the LV's figures and its verdict.
  /// @param page where; empty: report.html in the study
  /// @param anew also where the report stands for what the study holds
  nlohmann::json report(const std::filesystem::path& page, bool anew);

  /// For a command that starts after it: the stage must be up to date, or edited.
  /// @throws Error{InvalidInput} naming the command to run first
  void require(study::Stage stage);

  /// Ends a command that succeeded: has the study remember what it was given, though every stage
  /// was kept, and says which stages ran and which were kept, if any was.
  void finish();

 private:
  /// Whether the study's result of the stage stays as it is; takes note of it if so.
  bool keeps(study::Stage stage, const study::Wanted& wanted);
  /// Runs a stage with the listener, and takes note of its warnings for the study's record.
  void run(study::Stage stage, const std::function<void(StageContext&)>& body);
  /// Notes in the study that the recipe refuses what a stage gave; only the first counts.
  void note_refusal(study::Stage stage, const std::string& reason);
  void forget_refusal();
  /// Writes what a stage made into the study, if there is one, and takes note of it.
  void leave(study::Stage stage, study::StageRecord record,
             const std::function<study::FileList()>& write);
  [[nodiscard]] static study::StageRecord new_record(study::Wanted with);
  [[nodiscard]] study::StageRecord new_record(study::Stage stage) const;
  /// Segments what was imported and leaves that in the study.
  void segment_anew(StageContext& context);
  void pictures();
  void refuse_another_source() const;
  /// Whether the study's import is of these files, and of the same exam among them.
  [[nodiscard]] bool is_of_same_exam(const study::Wanted& with) const;
  /// The same, or whether the stack that was read is the study's, whatever lies beside its files.
  /// @pre facts_ have the hash of the stack that was read
  [[nodiscard]] bool is_of_same_images(const study::Wanted& with) const;
  /// @throws Error{InvalidInput} where something was edited by hand, other images were read and
  /// edits are not to be given up
  void refuse_unless_from(const study::Wanted& with) const;
  /// Before what was imported is replaced. @throws Error{InvalidInput} where segment was edited by
  /// hand for other slices or phases, and that is not to be given up
  void refuse_unless_edits_fit();
  /// @param file of the stage segment, which has that grid and phases
  /// @throws Error{InvalidInput} unless the exam has them, too: the file is stale, or was edited by
  /// hand on other images
  void demand_fit(const Grid& grid, int phases, const std::string& file);
  /// Corrections that the study kept are of the heart in its images: they go with them.
  /// @throws Error{InvalidInput} where other images were read and edits are not to be given up
  void part_with_corrections(const study::Wanted& with);
  /// Takes note of the exam that was read and leaves it in the study.
  void leave_import(const study::Wanted& with);

  const Exam& exam();
  const Segmentation& segmentation();
  const std::vector<ShapeCycle>& shapes();
  const std::vector<FieldCycle>& field_cycles();
  const std::vector<SurfaceCycle>& surface_cycles();
  /// The leak alarm on segmentation_, in images that are at hand.
  /// @throws Error{Quality} if it rings and the recipe makes that an error; its pictures are left.
  void ask_for_leaks(StageContext& context);
  /// Cuts the part of the stack that a package's volume is made of, around the heart's shape.
  void keep_heart_images();
  /// The LV's long axis and the map to the workspace: with a study those of its files count.
  [[nodiscard]] std::optional<LongAxis> axis() const;
  [[nodiscard]] Affine workspace_from_lps() const;
  const std::vector<SurfaceMap>& surface_maps();
  void note_for_package();
  /// The images around the heart as the package holds them.
  [[nodiscard]] pack::PackedVolume packed_volume(const FieldCycle& heart);
  /// Gathers what a report tells of the exam and its labels, of surfaces that are of these labels,
  /// and of the package that was made last.
  void gather_labels(report::ReportInput& input);
  void gather_surfaces(report::ReportInput& input, const StageContext& context);
  void gather_package(report::ReportInput& input);
  void note_exam();
  void note_segmentation();
  /// What Pack is to be run with for a scene.
  [[nodiscard]] study::Wanted wanted_pack(const Scene& scene);
  /// Whether `file` is the package that would be written.
  [[nodiscard]] bool is_packed(const study::Wanted& with, const std::filesystem::path& file) const;
  [[nodiscard]] std::vector<Structure> needed(const Scene& scene);
  /// The scene last asked for; else that of the study's package; else the default one.
  [[nodiscard]] Scene told_scene() const;
  /// Asks of what is known by now what the report asks too.
  /// @param surfaces none: not yet made
  /// @throws Error{Quality} if the report would call it rejected
  void demand_usable(const Scene& scene, const std::vector<SurfaceCycle>& surfaces);

  Listener& listener_;
  Orders orders_;
  std::optional<study::Study> study_;
  ScenePlan plan_ = plan_of_study({.content = "anatomy"});  ///< as `make` is asked
  Facts facts_;
  std::vector<study::Stage> kept_;
  std::vector<study::Stage> made_;
  std::vector<std::string> warnings_;  ///< of the stage that runs
  bool refused_ = false;               ///< by this build

  std::optional<Exam> exam_;
  std::optional<Segmentation> segmentation_;
  std::optional<HeartImages> heart_images_;  ///< kept where the exam itself is not
  std::optional<std::vector<ShapeCycle>> shapes_;
  std::optional<std::vector<FieldCycle>> fields_;
  std::optional<std::vector<SurfaceCycle>> surfaces_;
  std::optional<std::vector<SurfaceMap>> maps_;
  bool exam_noted_ = false;
  bool segmentation_noted_ = false;
  std::optional<Scene> scene_;      ///< that was asked for
  bool reads_uncertainty_ = false;  ///< of a segmentation that is read, for the report
};

}  // namespace beatlas::build
