#include "pipeline/study/solve_files.h"

#include <algorithm>

#include "pipeline/study/files.h"
#include "pipeline/study/images.h"
#include "pipeline/study/json_values.h"
#include "runtime/base/error.h"
#include "runtime/base/json_object.h"

namespace beatlas::study {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

constexpr auto kIndex = "solve/solve.json";

std::string file_of(const std::string& image) { return "solve/" + image + ".nii.gz"; }

SolveMemory memory_from(const fs::path& study, const json& content, const std::string& key) {
  JsonObject object(content, "");
  std::string found;
  object.read("key", found);
  if (found != key) return {};
  SolveMemory memory;
  for (const auto& [name, list] : object.at("numbers").items()) {
    memory.numbers[name] = numbers_from_json(list, "/numbers/" + name);
  }
  for (const auto& [name, image] : object.at("images").items()) {
    const std::string path = "/images/" + name;
    JsonObject told(image, path);
    const Grid grid = grid_from_json(told.at("grid"), path + "/grid");
    int phases = 0;
    told.read("phases", phases, 1, 10000);
    told.finish();
    memory.images[name] = read_labels(study / file_of(name), {grid, grid, phases});
  }
  object.finish();
  return memory;
}

}  // namespace

FileList write_solve_memory(const fs::path& study, const SolveMemory& memory,
                            const std::string& key, double frame_interval_s) {
  make_folder(study / "solve");
  FileList files{kIndex};
  json images = json::object();
  for (const auto& [name, labels] : memory.images) {
    write_labels(study / file_of(name), labels, labels.grid, frame_interval_s);
    files.push_back(file_of(name));
    images[name] = {{"grid", grid_to_json(labels.grid)}, {"phases", labels.phase_count()}};
  }
  write_text(study / kIndex,
             json{{"key", key}, {"numbers", memory.numbers}, {"images", images}}.dump() + "\n");
  return files;
}

SolveMemory read_solve_memory(const Study& study, const std::string& key) {
  const StageRecord* record = study.find(Stage::Segment);
  if (record == nullptr || record->outputs.count(kIndex) == 0) return {};
  const bool whole =
      std::all_of(record->outputs.begin(), record->outputs.end(), [&](const auto& output) {
        const auto& [file, hash] = output;
        return !file.starts_with("solve/") || holds(study.folder() / file, hash);
      });
  if (!whole) return {};
  try {
    return memory_from(study.folder(), read_json(study.folder() / kIndex), key);
  } catch (const Error&) {
    return {};  // written by another version
  }
}

}  // namespace beatlas::study
