#include "pipeline/study/files.h"
#include "pipeline/study/images.h"
#include "pipeline/study/json_values.h"
#include "pipeline/study/stage_files.h"
#include "pipeline/study/structure_list.h"
#include "runtime/base/error.h"
#include "runtime/base/json_object.h"

namespace beatlas::study {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

std::string coverage_name(Structure structure) {
  return "coverage_" + std::string(structure_name(structure)) + ".nii.gz";
}

}  // namespace

FileList write_segmentation(const fs::path& study, const Segmentation& segmentation,
                            double frame_interval_s) {
  const fs::path folder = study / "segment";
  make_folder(folder);
  FileList files{"segment/segment.json", "segment/labels.nii.gz"};
  const LabelCycle& labels = segmentation.labels;
  const CoverageCycle& coverage = segmentation.coverage;
  write_labels(folder / "labels.nii.gz", labels, labels.grid, frame_interval_s);
  std::vector<Structure> structures;
  for (const auto& [structure, phases] : coverage.phases) {
    const std::string name = coverage_name(structure);
    write_images(folder / name, {coverage.grid, phases}, coverage.grid, frame_interval_s);
    structures.push_back(structure);
    files.push_back("segment/" + name);
  }
  write_json(folder / "segment.json", {{"grid", grid_to_json(labels.grid)},
                                       {"phases", labels.phase_count()},
                                       {"coverage_grid", grid_to_json(coverage.grid)},
                                       {"coverage_first", coverage.first},
                                       {"structures", structures_to_json(structures)},
                                       {"end_diastole", segmentation.end_diastole},
                                       {"end_systole", segmentation.end_systole},
                                       {"warnings", segmentation.warnings}});
  return files;
}

Segmentation read_segmentation(const fs::path& study) {
  const fs::path folder = study / "segment";
  const fs::path index = folder / "segment.json";
  const json content = read_json(index);
  try {
    JsonObject object(content, "");
    Segmentation out;
    const Grid grid = grid_from_json(object.at("grid"), "/grid");
    int phases = 0;
    object.read("phases", phases, 1, 10000);
    out.labels = read_labels(folder / "labels.nii.gz", {grid, grid, phases});
    out.coverage.grid = grid_from_json(object.at("coverage_grid"), "/coverage_grid");
    out.coverage.first = index_from_json(object.at("coverage_first"), "/coverage_first");
    for (Structure structure : structures_from_json(object.at("structures"), "/structures")) {
      out.coverage.phases[structure] = read_images(folder / coverage_name(structure),
                                                   {out.coverage.grid, out.coverage.grid, phases})
                                           .phases;
    }
    object.read("end_diastole", out.end_diastole, 0, phases - 1);
    object.read("end_systole", out.end_systole, 0, phases - 1);
    out.warnings = strings_from_json(object.at("warnings"), "/warnings");
    object.finish();
    return out;
  } catch (const Error& error) {
    throw error.with_context(index.string());
  }
}

}  // namespace beatlas::study
