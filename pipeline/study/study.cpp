#include "pipeline/study/study.h"

#include <system_error>

#include "pipeline/study/files.h"
#include "runtime/base/error.h"
#include "runtime/base/json_object.h"

namespace beatlas::study {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

constexpr int kStudyFormat = 1;
constexpr auto kIndexName = "study.json";

/// The stages whose outputs a stage reads.
std::vector<Stage> sources_of(Stage stage) {
  switch (stage) {
    case Stage::Import:
      return {};
    case Stage::Segment:
      return {Stage::Import};
    case Stage::Register:
      return {Stage::Import, Stage::Segment};
    case Stage::Field:
      return {Stage::Register};
    case Stage::Mesh:
      return {Stage::Field};
    case Stage::Pack:
      return {Stage::Import, Stage::Segment, Stage::Register, Stage::Field, Stage::Mesh};
  }
  return {};
}

json to_json(const StageRecord& record) {
  json out{{"version", record.version},
           {"options", record.options},
           {"inputs", record.inputs},
           {"outputs", record.outputs}};
  if (record.stale) out["stale"] = true;
  return out;
}

std::map<std::string, std::string> hashes(const json& object, const std::string& path) {
  std::map<std::string, std::string> out;
  if (!object.is_object()) throw_invalid(path + " must be a JSON object");
  for (const auto& item : object.items()) {
    if (!item.value().is_string()) throw_invalid(path + "/" + item.key() + " must be a string");
    // The names are joined to the study's folder and removed when stale: none may lead out of it.
    const fs::path name(item.key());
    bool leads_out = name.is_absolute();
    for (const fs::path& part : name) leads_out = leads_out || part == "..";
    if (leads_out) throw_invalid(path + "/" + item.key() + " leads out of the study's folder");
    out[item.key()] = item.value().get<std::string>();
  }
  return out;
}

StageRecord record_from_json(const json& value, const std::string& path) {
  JsonObject object(value, path);
  StageRecord record;
  object.read("version", record.version);
  record.options = object.at("options");
  record.inputs = hashes(object.at("inputs"), path + "/inputs");
  record.outputs = hashes(object.at("outputs"), path + "/outputs");
  object.read("stale", record.stale);
  object.finish();
  return record;
}

}  // namespace

std::string_view stage_name(Stage stage) noexcept {
  constexpr std::array<std::string_view, kAllStages.size()> kNames{"import", "segment", "register",
                                                                   "field",  "mesh",    "pack"};
  return kNames[static_cast<std::size_t>(stage)];
}

Study Study::create(const fs::path& folder) {
  std::error_code ignored;
  if (fs::exists(folder / kIndexName, ignored)) return open(folder);
  if (fs::is_directory(folder, ignored) && !fs::is_empty(folder, ignored)) {
    throw_invalid("the folder " + folder.string() +
                  " holds other files and no study; name a new or empty folder with --study");
  }
  make_folder(folder);
  check_writable(folder / kIndexName);
  Study study;
  study.folder_ = folder;
  return study;
}

Study Study::open(const fs::path& folder) {
  std::error_code ignored;
  const fs::path index = folder / kIndexName;
  if (!fs::is_regular_file(index, ignored)) {
    throw_invalid("there is no study in " + folder.string() +
                  "; start one with: beatlas import SOURCE... --study " + folder.string());
  }
  Study study;
  study.folder_ = folder;
  const json content = read_json(index);
  try {
    JsonObject object(content, "");
    int format = 0;
    object.read("study_format", format, 0, 1 << 30);
    if (format != kStudyFormat) {
      throw_invalid("/study_format is " + std::to_string(format) + ", this program reads " +
                    std::to_string(kStudyFormat));
    }
    if (object.has("recipe")) study.recipe_ = object.at("recipe");
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

bool Study::has(Stage stage) const {
  const auto found = records_.find(stage);
  return found != records_.end() && !found->second.stale;
}

const StageRecord& Study::record(Stage stage) const {
  const auto found = records_.find(stage);
  const std::string name(stage_name(stage));
  if (found == records_.end()) {
    throw_invalid("the study " + folder_.string() + " has no result of the stage " + name +
                  "; run: beatlas " + name + " --study " + folder_.string());
  }
  if (found->second.stale) {
    throw_invalid("in the study " + folder_.string() + " the stage " + name +
                  " is older than what it was made from; run: beatlas " + name + " --study " +
                  folder_.string());
  }
  return found->second;
}

std::vector<std::string> Study::edited_outputs(Stage stage) const {
  std::vector<std::string> edited;
  for (const auto& [file, hash] : record(stage).outputs) {
    std::error_code ignored;
    const fs::path path = folder_ / file;
    if (!fs::is_regular_file(path, ignored) || sha256_of_file(path) != hash) edited.push_back(file);
  }
  return edited;
}

void Study::commit(Stage stage, const std::string& version, json options,
                   const std::vector<std::string>& files, const std::string& source_sha256) {
  StageRecord next;
  next.version = version;
  next.options = std::move(options);
  if (stage == Stage::Import) next.inputs["source"] = source_sha256;
  for (Stage source : sources_of(stage)) {
    if (!has(source)) continue;  // a scene without surfaces is packed without meshing
    for (const auto& output : record(source).outputs) {
      next.inputs[output.first] = sha256_of_file(folder_ / output.first);
    }
  }
  for (const std::string& file : files) next.outputs[file] = sha256_of_file(folder_ / file);

  std::map<std::string, std::string> former;
  if (const auto found = records_.find(stage); found != records_.end()) {
    former = found->second.outputs;
  }
  records_[stage] = std::move(next);
  for (auto& [other, record] : records_) {
    if (other > stage) record.stale = true;
  }
  save();
  for (const auto& output : former) {
    std::error_code ignored;
    if (records_[stage].outputs.count(output.first) == 0)
      fs::remove(folder_ / output.first, ignored);
  }
}

void Study::save() const {
  json content{{"study_format", kStudyFormat}, {"stages", json::object()}};
  if (recipe_) content["recipe"] = *recipe_;
  for (const auto& [stage, record] : records_) {
    content["stages"][std::string(stage_name(stage))] = to_json(record);
  }
  write_json(folder_ / kIndexName, content);
}

}  // namespace beatlas::study
