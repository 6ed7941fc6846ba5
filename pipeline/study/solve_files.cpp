#include "pipeline/study/solve_files.h"

#include <algorithm>
#include <utility>

#include "pipeline/core/parallel.h"
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
  std::vector<std::string> names;
  std::vector<ExpectedImages> expected;
  for (const auto& [name, image] : object.at("images").items()) {
    const std::string path = "/images/" + name;
    JsonObject told(image, path);
    const Grid grid = grid_from_json(told.at("grid"), path + "/grid");
    int phases = 0;
    told.read("phases", phases, 1, 10000);
    told.finish();
    names.push_back(name);
    expected.push_back({grid, grid, phases});
  }
  object.finish();
  std::vector<LabelCycle> images(names.size());
  parallel_for(names.size(), [&](std::size_t at) {
    images[at] = read_labels(study / file_of(names[at]), expected[at]);
  });
  for (std::size_t at = 0; at < names.size(); ++at) {
    memory.images[names[at]] = std::move(images[at]);
  }
  return memory;
}

}  // namespace

FileList write_solve_memory(const fs::path& study, const SolveMemory& memory,
                            const std::string& key, double frame_interval_s) {
  make_folder(study / "solve");
  FileList files{kIndex};
  json images = json::object();
  std::vector<const LabelCycle*> written;
  for (const auto& [name, labels] : memory.images) {
    written.push_back(&labels);
    files.push_back(file_of(name));
    images[name] = {{"grid", grid_to_json(labels.grid)}, {"phases", labels.phase_count()}};
  }
  parallel_for(written.size(), [&](std::size_t at) {
    write_labels(study / files[at + 1], written[at]->phases, written[at]->grid, frame_interval_s);
  });
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
