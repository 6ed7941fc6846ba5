#include <algorithm>
#include <array>
#include <cstdio>

#include "pipeline/core/phantom_mark.h"
#include "pipeline/study/files.h"
#include "pipeline/study/images.h"
#include "pipeline/study/json_values.h"
#include "pipeline/study/stage_files.h"
#include "runtime/base/error.h"
#include "runtime/base/json_object.h"

namespace beatlas::study {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

constexpr int kMostPhases = 1 << 12;

json write_cine(const fs::path& folder, const std::string& name, const Cine& cine) {
  write_images(folder / name, cine.images.phases, cine.grid(), cine.frame_interval_s());
  return {{"file", name},
          {"grid", grid_to_json(cine.grid())},
          {"phases", cine.phase_count()},
          {"rr_interval_s", cine.rr_interval_s},
          {"frame_times_s", cine.frame_times_s}};
}

Cine read_cine(const fs::path& folder, const json& value, const std::string& name,
               const std::string& path) {
  JsonObject object(value, path);
  Cine cine;
  std::string file;
  object.read("file", file);
  if (file != name) throw_invalid(path + "/file must be " + name);
  const Grid grid = grid_from_json(object.at("grid"), path + "/grid");
  int phases = 0;
  object.read("phases", phases, 1, kMostPhases);
  object.read("rr_interval_s", cine.rr_interval_s, 1e-3, 1e3);
  cine.frame_times_s = numbers_from_json(object.at("frame_times_s"), path + "/frame_times_s");
  object.finish();
  cine.images = read_images(folder / name, {grid, grid, phases});
  return cine;
}

std::vector<Vec2> slice_shifts_from_json(const json& value, int slices) {
  const std::string path = "/slice_shifts_mm";
  if (!value.is_array() || value.size() != static_cast<std::size_t>(slices)) {
    throw_invalid(path + " must be a list of a pair of numbers for each slice");
  }
  std::vector<Vec2> out;
  for (std::size_t k = 0; k < value.size(); ++k) {
    const std::string at = path + "/" + std::to_string(k);
    const std::vector<double> pair = numbers_from_json(value[k], at);
    if (pair.size() != 2) throw_invalid(at + " must be a pair of numbers");
    out.emplace_back(pair[0], pair[1]);
  }
  return out;
}

std::vector<int> slice_lags_from_json(const json& value, int slices, int phases) {
  const auto fits = [&](const json& lag) {
    return lag.is_number_integer() && lag.get<double>() > -phases && lag.get<double>() < phases;
  };
  if (!value.is_array() || value.size() != static_cast<std::size_t>(slices) ||
      !std::all_of(value.begin(), value.end(), fits)) {
    throw_invalid("/slice_lags must be a list of a whole number of phases for each slice");
  }
  return value.get<std::vector<int>>();
}

std::string view_name(std::size_t view) {
  std::array<char, 48> name{};
  std::snprintf(name.data(), name.size(), "view_%02zu.nii.gz", view);
  return name.data();
}

}  // namespace

FileList write_exam(const fs::path& study, const Exam& exam) {
  const fs::path folder = study / "exam";
  make_folder(folder);
  FileList files{"exam/exam.json", "exam/stack.nii.gz"};
  json content{{"stack", write_cine(folder, "stack.nii.gz", exam.stack)},
               {"views", json::array()},
               {"decisions", exam.decisions},
               {"source_format", exam.source_format}};
  for (const Vec2& shift : exam.slice_shifts_mm) {
    content["slice_shifts_mm"].push_back({shift[0], shift[1]});
  }
  if (!exam.slice_lags.empty()) content["slice_lags"] = exam.slice_lags;
  if (!exam.phantom_identity.empty()) content["phantom_identity"] = exam.phantom_identity;
  for (std::size_t view = 0; view < exam.views.size(); ++view) {
    content["views"].push_back(write_cine(folder, view_name(view), exam.views[view]));
    files.push_back("exam/" + view_name(view));
  }
  write_json(folder / "exam.json", content);
  return files;
}

Exam read_exam(const fs::path& study) {
  const fs::path folder = study / "exam";
  const fs::path index = folder / "exam.json";
  const json content = read_json(index);
  try {
    JsonObject object(content, "");
    Exam exam;
    exam.stack = read_cine(folder, object.at("stack"), "stack.nii.gz", "/stack");
    const json& views = object.at("views");
    if (!views.is_array()) throw_invalid("/views must be a list");
    for (std::size_t view = 0; view < views.size(); ++view) {
      exam.views.push_back(
          read_cine(folder, views[view], view_name(view), "/views/" + std::to_string(view)));
    }
    exam.decisions = strings_from_json(object.at("decisions"), "/decisions");
    if (object.has("slice_shifts_mm")) {
      exam.slice_shifts_mm =
          slice_shifts_from_json(object.at("slice_shifts_mm"), exam.stack.grid().size[2]);
    }
    if (object.has("slice_lags")) {
      exam.slice_lags = slice_lags_from_json(object.at("slice_lags"), exam.stack.grid().size[2],
                                             exam.stack.phase_count());
    }
    object.read("source_format", exam.source_format);
    object.read("phantom_identity", exam.phantom_identity);
    if (!exam.phantom_identity.empty() && !is_phantom_identity(exam.phantom_identity)) {
      throw_invalid("/phantom_identity must be 64 lower-case hexadecimal digits");
    }
    object.finish();
    return exam;
  } catch (const Error& error) {
    throw said_of(index, error);
  }
}

StackLattice read_stack_lattice(const fs::path& study) {
  const fs::path index = study / "exam" / "exam.json";
  const json content = read_json(index);
  try {
    JsonObject object(content, "");
    JsonObject stack(object.at("stack"), "/stack");
    StackLattice out{grid_from_json(stack.at("grid"), "/stack/grid"), 0};
    stack.read("phases", out.phases, 1, kMostPhases);
    return out;
  } catch (const Error& error) {
    throw said_of(index, error);
  }
}

}  // namespace beatlas::study
