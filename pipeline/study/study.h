#pragma once
/// A study: the folder in which every stage of a build leaves its values in standard formats.
///
///   study.json                          what ran: version, options, hashes of inputs and outputs
///   exam/     exam.json stack.nii.gz view_NN.nii.gz
///   segment/  segment.json labels.nii.gz coverage_<structure>.nii.gz
///   register/ register.json cine.nii.gz labels.nii.gz shape_<structure>.nii.gz
///   field/    field.json <structure>.vdb
///   mesh/     mesh.json <structure>_<phase>.ply
///   pictures/ overlay.png volumes.svg
///
/// What one stage writes, the next reads back without loss: stage by stage gives the same package
/// as a build in one go. Files are replaced whole, never half written.

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

namespace beatlas::study {

enum class Stage { Import, Segment, Register, Field, Mesh, Pack };

inline constexpr std::array kAllStages{Stage::Import, Stage::Segment, Stage::Register,
                                       Stage::Field,  Stage::Mesh,    Stage::Pack};

/// The command of the stage: "import", "segment", "register", "field", "mesh", "pack".
[[nodiscard]] std::string_view stage_name(Stage stage) noexcept;

/// What study.json keeps of a stage that ran.
struct StageRecord {
  std::string version;  ///< of the program
  nlohmann::json options = nlohmann::json::object();
  std::map<std::string, std::string> inputs;   ///< file in the study, or "source" -> SHA-256
  std::map<std::string, std::string> outputs;  ///< file in the study -> SHA-256
  bool stale = false;                          ///< a stage before it ran again since
};

class Study {
 public:
  /// Opens the study in `folder`, or starts one in a new or empty folder.
  /// @throws Error{InvalidInput} if the folder holds other things; Error{Machine} if unwritable.
  [[nodiscard]] static Study create(const std::filesystem::path& folder);
  /// @throws Error{InvalidInput} if there is no study or study.json cannot be used.
  [[nodiscard]] static Study open(const std::filesystem::path& folder);

  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }

  /// The recipe the study was started with; stages use it unless they are given another.
  [[nodiscard]] const std::optional<nlohmann::json>& recipe() const { return recipe_; }
  void set_recipe(nlohmann::json recipe) { recipe_ = std::move(recipe); }

  [[nodiscard]] bool has(Stage stage) const;
  /// @throws Error{InvalidInput} if the stage has not run, or not since a stage before it ran; the
  /// message names the command to run.
  [[nodiscard]] const StageRecord& record(Stage stage) const;

  /// Outputs of `stage` whose bytes are no longer those it wrote: edited by hand, or gone.
  [[nodiscard]] std::vector<std::string> edited_outputs(Stage stage) const;

  /// Notes that `stage` has run and written `files` (relative to the folder): hashes them and the
  /// outputs of the stages it reads, marks the later stages stale, removes files of its former
  /// run that this one no longer has, and writes study.json.
  /// @param source_sha256 hash of the decoded source; for Stage::Import only
  void commit(Stage stage, const std::string& version, nlohmann::json options,
              const std::vector<std::string>& files, const std::string& source_sha256 = {});

 private:
  void save() const;

  std::filesystem::path folder_;
  std::optional<nlohmann::json> recipe_;
  std::map<Stage, StageRecord> records_;
};

}  // namespace beatlas::study
