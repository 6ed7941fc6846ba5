#include <array>
#include <cmath>
#include <functional>

#include "pipeline/core/parallel.h"
#include "pipeline/study/files.h"
#include "pipeline/study/images.h"
#include "pipeline/study/json_values.h"
#include "pipeline/study/long_axis_json.h"
#include "pipeline/study/stage.h"
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

/// @param path of the object
Structure read_structure(JsonObject& object, const std::string& path) {
  std::string name;
  object.read("structure", name);
  const std::optional<Structure> structure = structure_from_name(name);
  if (!structure) throw_invalid(path + "/structure is not the name of a structure");
  return *structure;
}

void read_planes(const json& list, const std::string& path, int phases, Segmentation& out) {
  if (!list.is_array()) throw_invalid(path + " must be a list");
  for (std::size_t at = 0; at < list.size(); ++at) {
    const std::string here = path + "/" + std::to_string(at);
    JsonObject object(list[at], here);
    const Structure structure = read_structure(object, here);
    ValvePlane plane;
    object.read("base_step", plane.base_step, -1, 1);
    plane.k = numbers_from_json(object.at("k"), here + "/k");
    object.finish();
    if (plane.base_step == 0 || plane.k.size() != static_cast<std::size_t>(phases)) {
      throw_invalid(here + " must have a base_step of 1 or -1 and a number k for each phase");
    }
    out.valve_planes[structure] = std::move(plane);
  }
}

json alarms_to_json(const std::vector<LeakAlarm>& alarms) {
  json out = json::array();
  for (const LeakAlarm& alarm : alarms) {
    out.push_back({{"kind", leak_kind_name(alarm.kind)},
                   {"structure", structure_name(alarm.structure)},
                   {"phase", alarm.phase},
                   {"lps_mm", {alarm.lps_mm[0], alarm.lps_mm[1], alarm.lps_mm[2]}},
                   {"figure", alarm.figure},
                   {"limit", alarm.limit},
                   {"sentence", alarm.sentence},
                   {"sign", alarm.sign}});
    for (const LeakSeed& seed : alarm.seeds) {
      out.back()["seeds"].push_back({{"label", seed.label},
                                     {"lps_mm", {seed.lps_mm[0], seed.lps_mm[1], seed.lps_mm[2]}},
                                     {"radius_mm", seed.radius_mm},
                                     {"phase", seed.phase}});
    }
  }
  return out;
}

LeakSeed seed_from_json(const json& value, const std::string& path, int phases) {
  JsonObject object(value, path);
  LeakSeed seed;
  int label = 0;
  object.read("label", label, kLabelBackground, kLabelRestOfHeart);
  seed.label = static_cast<std::uint8_t>(label);
  const std::vector<double> place = numbers_from_json(object.at("lps_mm"), path + "/lps_mm");
  if (place.size() != 3) throw_invalid(path + "/lps_mm must be three numbers");
  seed.lps_mm = Vec3(place[0], place[1], place[2]);
  object.read("radius_mm", seed.radius_mm, 0.1, 50.0);
  object.read("phase", seed.phase, -1, phases - 1);
  object.finish();
  return seed;
}

std::vector<LeakSeed> seeds_from_json(const json& list, const std::string& path, int phases) {
  if (!list.is_array()) throw_invalid(path + " must be a list");
  std::vector<LeakSeed> out;
  for (std::size_t at = 0; at < list.size(); ++at) {
    out.push_back(seed_from_json(list[at], path + "/" + std::to_string(at), phases));
  }
  return out;
}

void read_alarms(const json& list, const std::string& path, int phases, Segmentation& out) {
  if (!list.is_array()) throw_invalid(path + " must be a list");
  for (std::size_t at = 0; at < list.size(); ++at) {
    const std::string here = path + "/" + std::to_string(at);
    JsonObject object(list[at], here);
    LeakAlarm alarm;
    std::string kind;
    std::string structure;
    object.read("kind", kind);
    object.read("structure", structure);
    object.read("phase", alarm.phase, 0, phases - 1);
    const std::vector<double> place = numbers_from_json(object.at("lps_mm"), here + "/lps_mm");
    constexpr double kMost = 1e9;
    object.read("figure", alarm.figure, 0.0, kMost);
    object.read("limit", alarm.limit, 0.0, kMost);
    object.read("sentence", alarm.sentence);
    object.read("sign", alarm.sign, -1, 1);
    if (object.has("seeds")) {
      alarm.seeds = seeds_from_json(object.at("seeds"), here + "/seeds", phases);
    }
    if (object.has("seed")) (void)object.at("seed");  // of an earlier program, which tried none
    object.finish();
    const auto known_kind = leak_kind_from_name(kind);
    const auto known_structure = structure_from_name(structure);
    if (!known_kind || !known_structure || place.size() != 3) {
      throw_invalid(here + " must have the name of a kind and of a structure, and a place lps_mm");
    }
    alarm.kind = *known_kind;
    alarm.structure = *known_structure;
    alarm.lps_mm = Vec3(place[0], place[1], place[2]);
    out.alarms.push_back(std::move(alarm));
  }
}

constexpr int kMostLabelledPhases = 10000;

/// Of a structure three lists of lists, [phase][slice], in mm2.
json belief_to_json(const Belief& belief) {
  json out = json::array();
  for (const auto& [structure, phases] : belief) {
    json entry{{"structure", structure_name(structure)}};
    for (const std::vector<SliceBelief>& slices : phases) {
      std::array<json, 3> areas{json::array(), json::array(), json::array()};
      for (const SliceBelief& slice : slices) {
        areas[0].push_back(slice.labelled_mm2);
        areas[1].push_back(slice.expected_mm2);
        areas[2].push_back(slice.agreed_mm2);
      }
      entry["labelled_mm2"].push_back(areas[0]);
      entry["expected_mm2"].push_back(areas[1]);
      entry["agreed_mm2"].push_back(areas[2]);
    }
    out.push_back(std::move(entry));
  }
  return out;
}

constexpr double kMostAreaMm2 = 1e6;  ///< a square metre

/// The same back. @throws Error{InvalidInput} naming the entry
void read_belief(const json& list, const std::string& path, int phases, int slices, Belief& out) {
  if (!list.is_array()) throw_invalid(path + " must be a list");
  for (std::size_t at = 0; at < list.size(); ++at) {
    const std::string here = path + "/" + std::to_string(at);
    JsonObject object(list[at], here);
    const Structure structure = read_structure(object, here);
    auto& belief = out[structure];
    belief.assign(static_cast<std::size_t>(phases),
                  std::vector<SliceBelief>(static_cast<std::size_t>(slices)));
    const auto read = [&](const std::string& key, double SliceBelief::*area) {
      const json& areas = object.at(key);
      if (!areas.is_array() || areas.size() != belief.size()) {
        throw_invalid(here + "/" + key + " must have a list for each phase");
      }
      for (std::size_t p = 0; p < belief.size(); ++p) {
        const std::string phase = here + "/" + key + "/" + std::to_string(p);
        const std::vector<double> of_slices = numbers_from_json(areas[p], phase);
        if (of_slices.size() != belief[p].size()) {
          throw_invalid(phase + " must have a number for each slice");
        }
        for (std::size_t k = 0; k < of_slices.size(); ++k) {
          if (!(of_slices[k] >= 0 && of_slices[k] <= kMostAreaMm2)) {
            throw_invalid(phase + "/" + std::to_string(k) + " must be a number from 0 to 1e6");
          }
          belief[p][k].*area = of_slices[k];
        }
      }
    };
    read("labelled_mm2", &SliceBelief::labelled_mm2);
    read("expected_mm2", &SliceBelief::expected_mm2);
    read("agreed_mm2", &SliceBelief::agreed_mm2);
    object.finish();
  }
}

constexpr auto kLongAxisName = "long_axis.json";

LongAxis read_axis_file(const fs::path& study) {
  const fs::path file = study / "segment" / kLongAxisName;
  const json content = read_json(file);
  try {
    return long_axis_from_json(content);
  } catch (const Error& error) {
    throw said_of(file, error);
  }
}

std::string uncertainty_name(Structure structure) {
  return "uncertainty_" + std::string(structure_name(structure)) + ".nii.gz";
}

}  // namespace

FileList write_segmentation(const fs::path& study, const Segmentation& segmentation,
                            double frame_interval_s, const std::optional<LabelCycle>& as_acquired) {
  const fs::path folder = study / "segment";
  make_folder(folder);
  FileList files{"segment/segment.json", "segment/labels.nii.gz", kLabelsAsMade};
  const LabelCycle& labels = segmentation.labels;
  const CoverageCycle& coverage = segmentation.coverage;
  std::vector<std::function<void()>> writes;
  for (const fs::path& file : {folder / "labels.nii.gz", study / kLabelsAsMade}) {
    writes.emplace_back(
        [&, file] { write_labels(file, labels.phases, labels.grid, frame_interval_s); });
  }
  if (as_acquired) {
    writes.emplace_back([&] {
      write_labels(study / kLabelsAsAcquired, as_acquired->phases, as_acquired->grid,
                   frame_interval_s);
    });
    files.emplace_back(kLabelsAsAcquired);
  }
  std::vector<Structure> structures;
  for (const auto& [structure, phases] : coverage.phases) {
    const std::string name = coverage_name(structure);
    writes.emplace_back([&, &images = phases, name] {
      write_images(folder / name, images, coverage.grid, frame_interval_s);
    });
    structures.push_back(structure);
    files.push_back("segment/" + name);
  }
  std::vector<Structure> uncertain;
  for (const auto& [structure, phases] : segmentation.uncertainty) {
    const std::string name = uncertainty_name(structure);
    writes.emplace_back([&, &cycle = phases, name] {
      std::vector<std::vector<float>> sigma_mm;
      for (const std::vector<BoundaryPoint>& points : cycle) {
        sigma_mm.emplace_back(coverage.grid.count(), 0.0F);
        for (const BoundaryPoint& point : points) sigma_mm.back()[point.voxel] = point.sigma_mm;
      }
      write_images(folder / name, sigma_mm, coverage.grid, frame_interval_s);
    });
    uncertain.push_back(structure);
    files.push_back("segment/" + name);
  }
  parallel_for(writes.size(), [&](std::size_t at) { writes[at](); });
  if (segmentation.axis) {
    write_json(folder / kLongAxisName, long_axis_to_json(*segmentation.axis));
    files.push_back("segment/" + std::string(kLongAxisName));
  }
  json planes = json::array();
  for (const auto& [structure, plane] : segmentation.valve_planes) {
    planes.push_back(
        {{"structure", structure_name(structure)}, {"base_step", plane.base_step}, {"k", plane.k}});
  }
  write_json(folder / "segment.json", {{"grid", grid_to_json(labels.grid)},
                                       {"phases", labels.phase_count()},
                                       {"coverage_grid", grid_to_json(coverage.grid)},
                                       {"coverage_first", coverage.first},
                                       {"structures", structures_to_json(structures)},
                                       {"end_diastole", segmentation.end_diastole},
                                       {"end_systole", segmentation.end_systole},
                                       {"valve_planes", planes},
                                       {"long_axis", segmentation.axis.has_value()},
                                       {"uncertainty", structures_to_json(uncertain)},
                                       {"belief", belief_to_json(segmentation.belief)},
                                       {"warnings", segmentation.warnings},
                                       {"alarms", alarms_to_json(segmentation.alarms)}});
  return files;
}

StoredSegmentation read_segmentation(const fs::path& study) {
  const fs::path folder = study / "segment";
  const fs::path index = folder / "segment.json";
  const json content = read_json(index);
  int phases = 0;
  bool has_axis = false;
  StoredSegmentation stored;
  try {
    JsonObject object(content, "");
    Segmentation& out = stored.made;
    const Grid grid = grid_from_json(object.at("grid"), "/grid");
    object.read("phases", phases, 1, kMostLabelledPhases);
    stored.labels = read_labels(folder / "labels.nii.gz", {grid, grid, phases});
    out.labels = read_labels(study / kLabelsAsMade, {grid, grid, phases});
    out.coverage.grid = grid_from_json(object.at("coverage_grid"), "/coverage_grid");
    out.coverage.first = index_from_json(object.at("coverage_first"), "/coverage_first");
    for (Structure structure : structures_from_json(object.at("structures"), "/structures")) {
      out.coverage.phases[structure] = read_images(folder / coverage_name(structure),
                                                   {out.coverage.grid, out.coverage.grid, phases})
                                           .phases;
    }
    object.read("end_diastole", out.end_diastole, 0, phases - 1);
    object.read("end_systole", out.end_systole, 0, phases - 1);
    // Studies named the planes otherwise before they were an estimate alone; edited labels outlive
    // programs.
    const std::string planes = object.has("base_cuts") ? "base_cuts" : "valve_planes";
    read_planes(object.at(planes), "/" + planes, phases, out);
    out.warnings = strings_from_json(object.at("warnings"), "/warnings");
    if (object.has("alarms")) read_alarms(object.at("alarms"), "/alarms", phases, out);
    if (object.has("belief")) {
      read_belief(object.at("belief"), "/belief", phases, grid.size[2], out.belief);
    }
    object.read("long_axis", has_axis);
    if (object.has("uncertainty")) (void)object.at("uncertainty");
    object.finish();
  } catch (const Error& error) {
    throw said_of(index, error);
  }
  if (has_axis) {
    stored.made.axis = read_axis_file(study);
    if (stored.made.axis->apex_mm.size() != static_cast<std::size_t>(phases)) {
      throw_invalid((folder / kLongAxisName).string() + ": /phases must have " +
                    std::to_string(phases) + " entries, one for each phase of the images");
    }
  }
  return stored;
}

BoundaryUncertainty read_uncertainty(const fs::path& study) {
  const fs::path folder = study / "segment";
  const fs::path index = folder / "segment.json";
  const json content = read_json(index);
  try {
    JsonObject object(content, "");
    BoundaryUncertainty out;
    int phases = 0;
    object.read("phases", phases, 1, kMostLabelledPhases);
    const Grid grid = grid_from_json(object.at("coverage_grid"), "/coverage_grid");
    if (!object.has("uncertainty")) return out;
    for (Structure structure : structures_from_json(object.at("uncertainty"), "/uncertainty")) {
      const ImageCycle<float> sigma_mm =
          read_images(folder / uncertainty_name(structure), {grid, grid, phases});
      for (const std::vector<float>& phase : sigma_mm.phases) {
        std::vector<BoundaryPoint>& points = out[structure].emplace_back();
        for (std::size_t v = 0; v < phase.size(); ++v) {
          if (phase[v] > 0) points.push_back({static_cast<std::uint32_t>(v), phase[v]});
        }
      }
    }
    return out;
  } catch (const Error& error) {
    throw said_of(index, error);
  }
}

std::optional<LongAxis> read_long_axis(const fs::path& study) {
  const json content = read_json(study / "segment" / "segment.json");
  const auto has = content.find("long_axis");
  if (has == content.end() || !has->is_boolean() || !has->get<bool>()) return {};
  return read_axis_file(study);
}

}  // namespace beatlas::study
