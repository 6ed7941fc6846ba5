#include "pipeline/study/state.h"

#include <set>
#include <system_error>

#include "pipeline/study/files.h"

namespace beatlas::study {
namespace fs = std::filesystem;
namespace {

bool is_there(const Study& study, const std::string& file) {
  std::error_code ignored;
  return fs::is_regular_file(study.folder() / file, ignored);
}

bool was_changed(const Study& study, const std::string& file, const std::string& hash) {
  return is_there(study, file) && sha256_of_file(study.folder() / file) != hash;
}

}  // namespace

StageState state_of(const Study& study, Stage stage, const Wanted& wanted) {
  StageState out;
  const StageRecord* record = study.find(stage);
  if (!record) return out;
  out.ran = true;
  out.edited = edited_outputs(study, stage);
  for (const auto& [file, hash] : record->outputs) {
    const bool spoiled = file == kLabelsAsMade && was_changed(study, file, hash);
    if (spoiled || !is_there(study, file)) out.missing.push_back(file);
  }
  if (record->version != wanted.version) {
    out.changed.emplace_back("the program's version");
  } else if (record->sources_sha256 != wanted.sources_sha256 &&
             (stage != Stage::Import || wanted.source_files)) {
    out.changed.emplace_back("the program");
  }
  if (record->options != wanted.options) out.changed.emplace_back("its options");
  if (stage == Stage::Import) {
    const auto files = record->inputs.find(kSourceFiles);
    if (wanted.source_files &&
        (files == record->inputs.end() || files->second != *wanted.source_files)) {
      out.changed.emplace_back("the source");
    }
    return out;
  }
  for (const Stage source : sources_of(stage)) {
    if (study.find(source) != nullptr) continue;
    // It was stopped while it was made anew.
    out.changed.push_back("the stage " + std::string(stage_name(source)));
    return out;
  }
  const FileHashes now = study.inputs_now(stage);
  std::set<std::string> names;
  for (const auto& input : now) names.insert(input.first);
  for (const auto& input : record->inputs) names.insert(input.first);
  for (const std::string& name : names) {
    const auto then = record->inputs.find(name);
    const auto here = now.find(name);
    if (then == record->inputs.end() || here == now.end() || then->second != here->second) {
      out.changed.push_back(name);
    }
  }
  return out;
}

std::vector<std::string> edited_outputs(const Study& study, Stage stage) {
  std::vector<std::string> out;
  const StageRecord* record = study.find(stage);
  if (!record) return out;
  for (const auto& [file, hash] : record->outputs) {
    if (file == kLabelsAsMade || for_the_eye(file)) continue;
    if (was_changed(study, file, hash)) out.push_back(file);
  }
  return out;
}

std::vector<std::string> edited_for_the_eye(const Study& study, Stage stage) {
  std::vector<std::string> out;
  const StageRecord* record = study.find(stage);
  if (!record) return out;
  for (const auto& [file, hash] : record->outputs) {
    if (for_the_eye(file) && was_changed(study, file, hash)) out.push_back(file);
  }
  return out;
}

}  // namespace beatlas::study
