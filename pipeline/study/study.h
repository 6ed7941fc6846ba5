#pragma once
/// A study: the folder in which every stage of a build leaves its values in standard formats.
///
///   study.json                          what ran: version, options, hashes of inputs and outputs
///   given/    HASH.nii.gz                labels and paintings that a user gave
///   exam/     exam.json stack.nii.gz view_NN.nii.gz
///   segment/  segment.json labels.nii.gz labels_as_made.nii.gz coverage_<structure>.nii.gz
///             labels_source.nii.gz        the labels on the slices as acquired, if any was moved
///   pictures/ overlay.png volumes.svg leak_NN.png (refused_leak_NN.png of what was not kept)
///   register/ register.json cine.nii.gz labels.nii.gz shape_<structure>.nii.gz
///   field/    field.json <structure>.vdb
///   mesh/     mesh.json <structure>_<phase>.ply map_<structure>.csv
///   report.html report.json             what of it a technician and other programs want to know
///
/// What one stage writes, the next reads back without loss: stage by stage gives the same package
/// as a build in one go. Files are replaced whole, never half written; the record of a stage is
/// dropped before its first file is replaced and comes back after its last, so a stage that was
/// killed on the way runs again and is never taken for one that was edited by hand.

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "pipeline/study/lock.h"
#include "pipeline/study/stage.h"

namespace beatlas::study {

using FileHashes = std::map<std::string, std::string>;  ///< name -> SHA-256

/// What study.json keeps of a stage that ran.
struct StageRecord {
  std::string version;         ///< of the program
  std::string sources_sha256;  ///< of the program; empty from one that did not tell it
  nlohmann::json options = nlohmann::json::object();
  FileHashes inputs;                  ///< file in the study -> SHA-256; of Import: see Source
  FileHashes outputs;                 ///< file in the study -> SHA-256
  std::string package_sha256;         ///< of Pack: what it wrote, wherever that lies
  std::vector<std::string> warnings;  ///< what it said; none of Import, which may name files
};

/// That a recipe demanded more than a stage gave, and no package was made.
struct Refusal {
  Stage stage{};
  std::string reason;  ///< a sentence, without the study's place
};

/// What Import reads, as StageRecord::inputs keeps it.
inline constexpr auto kSourceStack = "source";        ///< the decoded stack
inline constexpr auto kSourceFiles = "source_files";  ///< bytes of the files that it read

/// Of a study that another program works on.
struct Waiting {
  std::function<void()> tell;                 ///< called once before waiting; may be empty
  const std::atomic<bool>* cancel = nullptr;  ///< looked at while waiting; may be null
};

class Study {
 public:
  /// Opens the study in `folder` to write, or starts one in a new or empty folder, with a
  /// study.json that tells of no stage; waits for another program that writes there, and clears
  /// away what a killed one left half written.
  /// @throws Error{InvalidInput} if the folder holds other things or links; Error{Machine} if
  /// unwritable.
  [[nodiscard]] static Study create(const std::filesystem::path& folder,
                                    const Waiting& waiting = {});
  /// The same for a study that must be there. @throws Error{InvalidInput}
  [[nodiscard]] static Study open_to_write(const std::filesystem::path& folder,
                                           const Waiting& waiting = {});
  /// To read. @throws Error{InvalidInput} if there is no study, study.json cannot be used or a link
  /// stands among the files.
  [[nodiscard]] static Study open(const std::filesystem::path& folder);

  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }

  /// What the study was made with; stages use it unless they are given another.
  [[nodiscard]] const std::optional<nlohmann::json>& recipe() const { return recipe_; }
  void set_recipe(nlohmann::json recipe) { recipe_ = std::move(recipe); }
  [[nodiscard]] const std::optional<nlohmann::json>& seeds() const { return seeds_; }
  void set_seeds(std::optional<nlohmann::json> seeds) { seeds_ = std::move(seeds); }
  /// Label images that were given, by what they are for; see given_files.h.
  [[nodiscard]] const nlohmann::json& given() const { return given_; }
  void set_given(nlohmann::json given) { given_ = std::move(given); }

  /// Nothing if the stage has not run to its end.
  [[nodiscard]] const StageRecord* find(Stage stage) const;
  /// The stage that began to write and was stopped before its end.
  [[nodiscard]] std::optional<Stage> interrupted() const { return writing_; }

  /// Of the last build; none since what was refused was made anew.
  [[nodiscard]] const std::optional<Refusal>& refusal() const { return refusal_; }
  void set_refusal(std::optional<Refusal> refusal) { refusal_ = std::move(refusal); }

  /// Hashes of what `stage` would read now: the outputs of its sources, less those for the eye
  /// and those that are gone.
  /// @throws Error{InvalidInput} naming the command to run if a source has not run
  [[nodiscard]] FileHashes inputs_now(Stage stage) const;

  /// Call before `stage` writes its first file. Drops its record; outputs for the eye that were
  /// changed by hand are put aside as NAME.edited.
  void begin(Stage stage);
  /// Call after it wrote the last of `files` (relative to the folder): hashes them and removes
  /// what a former run left and this one no longer has. `record.outputs` is filled here.
  void commit(Stage stage, StageRecord record, const std::vector<std::string>& files);

  /// Writes what was set; begin and commit do so too. @throws Error{Machine}
  void save() const;

 private:
  std::filesystem::path folder_;
  std::shared_ptr<const Lock> lock_;  ///< none: open to read
  std::optional<nlohmann::json> recipe_;
  std::optional<nlohmann::json> seeds_;
  nlohmann::json given_ = nlohmann::json::object();
  std::map<Stage, StageRecord> records_;
  std::optional<Stage> writing_;
  std::optional<Refusal> refusal_;
  std::set<std::string> former_;  ///< outputs of dropped records, until a stage is committed
};

}  // namespace beatlas::study
