#include "pipeline/study/study.h"

#include <cassert>
#include <system_error>
#include <utility>

#include "pipeline/core/words.h"
#include "pipeline/study/files.h"
#include "pipeline/study/json_values.h"
#include "runtime/base/error.h"
#include "runtime/base/json_object.h"

namespace beatlas::study {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

constexpr int kStudyFormat = 2;
constexpr auto kIndexName = "study.json";

json to_json(const StageRecord& record) {
  json out{{"version", record.version},
           {"sources_sha256", record.sources_sha256},
           {"options", record.options},
           {"inputs", record.inputs},
           {"outputs", record.outputs}};
  if (!record.package_sha256.empty()) out["package_sha256"] = record.package_sha256;
  if (!record.warnings.empty()) out["warnings"] = record.warnings;
  return out;
}

/// The names are joined to the study's folder and removed when stale: none may lead out of it.
void check_name(const std::string& file, const std::string& path) {
  const fs::path name(file);
  bool leads_out = name.is_absolute();
  for (const fs::path& part : name) leads_out = leads_out || part == "..";
  if (leads_out) throw_invalid(path + "/" + file + " leads out of the study's folder");
}

FileHashes hashes(const json& object, const std::string& path) {
  FileHashes out;
  if (!object.is_object()) throw_invalid(path + " must be a JSON object");
  for (const auto& item : object.items()) {
    if (!item.value().is_string()) throw_invalid(path + "/" + item.key() + " must be a string");
    check_name(item.key(), path);
    out[item.key()] = item.value().get<std::string>();
  }
  return out;
}

StageRecord record_from_json(const json& value, const std::string& path) {
  JsonObject object(value, path);
  StageRecord record;
  object.read("version", record.version);
  object.read("sources_sha256", record.sources_sha256);
  record.options = object.at("options");
  record.inputs = hashes(object.at("inputs"), path + "/inputs");
  record.outputs = hashes(object.at("outputs"), path + "/outputs");
  object.read("package_sha256", record.package_sha256);
  if (object.has("warnings")) {
    record.warnings = strings_from_json(object.at("warnings"), path + "/warnings");
  }
  object.finish();
  return record;
}

std::optional<Stage> stage_from_name(const std::string& name) {
  for (Stage stage : kAllStages) {
    if (stage_name(stage) == name) return stage;
  }
  return std::nullopt;
}

/// A study holds its files itself: through a link to elsewhere a name that looks harmless would be
/// read, written or removed outside. The folder itself may be reached by one.
void refuse_links(const fs::path& folder) {
  std::error_code failure;
  for (auto it = fs::recursive_directory_iterator(folder, failure);
       !failure && it != fs::recursive_directory_iterator(); it.increment(failure)) {
    std::error_code gone;
    if (!it->is_symlink(gone)) continue;
    throw_invalid(it->path().string() +
                  " is a link, and a study holds its files itself; put what it leads to in its "
                  "place, or remove it");
  }
  if (failure) {  // What cannot be listed may hold links.
    throw Error(ErrorCode::Machine, "the folders of the study " + folder.string() +
                                        " cannot all be listed: " + failure.message());
  }
}

/// Removes what a program that was killed left under temporary names.
void clear_partial_files(const fs::path& folder) {
  std::error_code ignored;
  std::vector<fs::path> found;
  for (auto it = fs::recursive_directory_iterator(folder, ignored);
       !ignored && it != fs::recursive_directory_iterator(); it.increment(ignored)) {
    if (is_partial(it->path())) found.push_back(it->path());
  }
  for (const fs::path& file : found) fs::remove(file, ignored);
}

}  // namespace

Study Study::create(const fs::path& folder, const Waiting& waiting) {
  make_folder(folder);
  const auto lock = std::make_shared<const Lock>(folder, waiting.tell, waiting.cancel);
  refuse_links(folder);
  std::error_code ignored;
  const bool there = fs::exists(folder / kIndexName, ignored);
  if (!there) {
    for (const auto& entry : fs::directory_iterator(folder, ignored)) {
      if (is_partial(entry.path())) continue;
      throw_invalid("the folder " + folder.string() +
                    " holds other files and no study; name a new or empty folder with --study");
    }
  }
  clear_partial_files(folder);
  check_writable(folder / kIndexName);
  Study study;
  if (there) study = open(folder);
  study.folder_ = folder;
  study.lock_ = lock;
  // From now on the folder is a study, whatever is left in it before its first stage has run.
  if (!there) study.save();
  return study;
}

Study Study::open_to_write(const fs::path& folder, const Waiting& waiting) {
  (void)open(folder);
  return create(folder, waiting);
}

Study Study::open(const fs::path& folder) {
  std::error_code failure;
  const fs::path index = folder / kIndexName;
  const bool there = fs::is_regular_file(index, failure);
  if (failure == std::errc::permission_denied) {
    throw Error(ErrorCode::Machine, index.string() + " cannot be read: no permission");
  }
  if (!there && fs::is_regular_file(folder, failure)) {
    throw_invalid(folder.string() +
                  " is a file, and no study's folder; name the folder that 'beatlas import' or "
                  "'beatlas build' left with --study");
  }
  if (!there) {
    throw_invalid("there is no study in " + folder.string() +
                  "; start one with: beatlas import SOURCE... --study " +
                  shell_word(folder.string()));
  }
  refuse_links(folder);
  Study study;
  study.folder_ = folder;
  json content;
  try {
    content = read_json(index);
  } catch (const Error& error) {
    throw Error(error.code(),
                std::string(error.what()) + "; put a copy of it back, or build into a new folder");
  }
  try {
    JsonObject object(content, "");
    int format = 0;
    object.read("study_format", format, 0, 1 << 30);
    if (format != kStudyFormat) {
      throw_invalid("/study_format is " + std::to_string(format) + ", this program reads " +
                    std::to_string(kStudyFormat) + "; build into a new folder");
    }
    if (object.has("recipe")) study.recipe_ = object.at("recipe");
    if (object.has("seeds")) study.seeds_ = object.at("seeds");
    if (object.has("given")) study.given_ = object.at("given");
    if (!study.given_.is_object()) throw_invalid("/given must be a JSON object");
    std::string writing;
    object.read("writing", writing);
    study.writing_ = stage_from_name(writing);
    if (!writing.empty() && !study.writing_) throw_invalid("/writing is not the name of a stage");
    if (object.has("refused")) {
      JsonObject told(object.at("refused"), "/refused");
      Refusal refusal;
      std::string stage;
      told.read("stage", stage);
      told.read("reason", refusal.reason);
      told.finish();
      if (!stage_from_name(stage)) throw_invalid("/refused/stage is not the name of a stage");
      refusal.stage = *stage_from_name(stage);
      study.refusal_ = std::move(refusal);
    }
    if (object.has("former")) {
      for (const std::string& file : strings_from_json(object.at("former"), "/former")) {
        check_name(file, "/former");
        study.former_.insert(file);
      }
    }
    JsonObject stages(object.at("stages"), "/stages");
    for (Stage stage : kAllStages) {
      const std::string name(stage_name(stage));
      if (!stages.has(name)) continue;
      study.records_[stage] = record_from_json(stages.at(name), "/stages/" + name);
    }
    stages.finish();
    object.finish();
  } catch (const Error& error) {
    throw error.with_context(index.string());
  }
  return study;
}

const StageRecord* Study::find(Stage stage) const {
  const auto found = records_.find(stage);
  return found == records_.end() ? nullptr : &found->second;
}

FileHashes Study::inputs_now(Stage stage) const {
  FileHashes out;
  for (Stage source : sources_of(stage)) {
    const StageRecord* record = find(source);
    if (!record) {
      throw_invalid("the study " + folder_.string() + " has no result of the stage " +
                    std::string(stage_name(source)) + "; run: beatlas " +
                    std::string(stage_command(source)) + " --study " +
                    shell_word(folder_.string()));
    }
    for (const auto& output : record->outputs) {
      const std::string& file = output.first;
      if (!reads(stage, source, file)) continue;
      std::error_code ignored;
      if (!fs::is_regular_file(folder_ / file, ignored)) continue;
      out[file] = sha256_of_file(folder_ / file);
    }
  }
  return out;
}

void Study::begin(Stage stage) {
  if (const StageRecord* record = find(stage)) {
    for (const auto& [file, hash] : record->outputs) {
      std::error_code ignored;
      const fs::path path = folder_ / file;
      if (for_the_eye(file) && fs::is_regular_file(path, ignored) && sha256_of_file(path) != hash) {
        fs::rename(path, path.string() + ".edited", ignored);
      }
    }
    for (const auto& output : record->outputs) former_.insert(output.first);
    records_.erase(stage);
  }
  writing_ = stage;
  save();
}

void Study::commit(Stage stage, StageRecord record, const std::vector<std::string>& files) {
  record.outputs.clear();
  for (const std::string& file : files) record.outputs[file] = sha256_of_file(folder_ / file);
  for (const std::string& file : std::exchange(former_, {})) {
    std::error_code ignored;
    if (record.outputs.count(file) == 0) fs::remove(folder_ / file, ignored);
  }
  records_[stage] = std::move(record);
  writing_.reset();
  save();
}

void Study::save() const {
  assert(lock_);
  json content{{"study_format", kStudyFormat}, {"stages", json::object()}};
  if (recipe_) content["recipe"] = *recipe_;
  if (seeds_) content["seeds"] = *seeds_;
  if (!given_.empty()) content["given"] = given_;
  if (writing_) content["writing"] = stage_name(*writing_);
  if (refusal_) {
    content["refused"] = {{"stage", stage_name(refusal_->stage)}, {"reason", refusal_->reason}};
  }
  if (!former_.empty()) content["former"] = former_;
  for (const auto& [stage, record] : records_) {
    content["stages"][std::string(stage_name(stage))] = to_json(record);
  }
  write_json(folder_ / kIndexName, content);
}

}  // namespace beatlas::study
