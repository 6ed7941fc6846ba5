#include <functional>
#include <vector>

#include "pipeline/core/parallel.h"
#include "pipeline/formats/nifti.h"
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

std::string shape_name(Structure structure) {
  return "shape_" + std::string(structure_name(structure)) + ".nii.gz";
}

Grid in_patient(const Grid& workspace_grid, const Affine& workspace_from_lps) {
  return {workspace_grid.size, workspace_from_lps.inverse() * workspace_grid.mm_from_index};
}

ShapeCycle read_shape(const fs::path& folder, const json& value, const std::string& path,
                      const Affine& workspace_from_lps) {
  JsonObject object(value, path);
  std::string name;
  object.read("structure", name);
  const std::optional<Structure> structure = structure_from_name(name);
  if (!structure) throw_invalid(path + "/structure is not the name of a structure");
  const Grid grid = grid_from_json(object.at("grid"), path + "/grid");
  int phases = 0;
  object.read("phases", phases, 1, 10000);
  object.finish();
  return {*structure, read_images(folder / shape_name(*structure),
                                  {in_patient(grid, workspace_from_lps), grid, phases})};
}

}  // namespace

FileList write_registration(const fs::path& study, const Affine& workspace_from_lps,
                            const std::vector<ShapeCycle>& shapes, const ImageCycle<float>& cine,
                            const LabelCycle& labels, double frame_interval_s) {
  const fs::path folder = study / "register";
  make_folder(folder);
  FileList files{"register/register.json", "register/cine.nii.gz", "register/labels.nii.gz"};
  const Affine& map = workspace_from_lps;
  std::vector<std::function<void()>> writes;
  // For the eye alone and never read back, so 16 bit are enough.
  writes.emplace_back([&] {
    replace_file(folder / "cine.nii.gz", [&](const fs::path& temporary) {
      formats::write_nifti(temporary, in_patient(cine.grid, map), cine.phases, frame_interval_s,
                           formats::NiftiStorage::Int16);
    });
  });
  writes.emplace_back([&] {
    write_labels(folder / "labels.nii.gz", labels.phases, in_patient(labels.grid, map),
                 frame_interval_s);
  });
  json content{{"workspace_from_lps", affine_to_json(map)}, {"shapes", json::array()}};
  for (const ShapeCycle& shape : shapes) {
    const std::string name = shape_name(shape.structure);
    writes.emplace_back([&, name] {
      write_images(folder / name, shape.level.phases, in_patient(shape.level.grid, map),
                   frame_interval_s);
    });
    files.push_back("register/" + name);
    content["shapes"].push_back({{"structure", structure_name(shape.structure)},
                                 {"grid", grid_to_json(shape.level.grid)},
                                 {"phases", shape.level.phase_count()}});
  }
  parallel_for(writes.size(), [&](std::size_t at) { writes[at](); });
  write_json(folder / "register.json", content);
  return files;
}

Registration read_registration(const fs::path& study) {
  const fs::path folder = study / "register";
  const fs::path index = folder / "register.json";
  const json content = read_json(index);
  try {
    JsonObject object(content, "");
    Registration out;
    out.workspace_from_lps =
        affine_from_json(object.at("workspace_from_lps"), "/workspace_from_lps");
    const json& shapes = object.at("shapes");
    if (!shapes.is_array()) throw_invalid("/shapes must be a list");
    out.shapes.resize(shapes.size());
    parallel_for(shapes.size(), [&](std::size_t at) {
      out.shapes[at] =
          read_shape(folder, shapes[at], "/shapes/" + std::to_string(at), out.workspace_from_lps);
    });
    object.finish();
    return out;
  } catch (const Error& error) {
    throw said_of(index, error);
  }
}

Affine read_workspace_from_lps(const fs::path& study) {
  const fs::path index = study / "register" / "register.json";
  const json content = read_json(index);
  try {
    return affine_from_json(JsonObject(content, "").at("workspace_from_lps"),
                            "/workspace_from_lps");
  } catch (const Error& error) {
    throw said_of(index, error);
  }
}

}  // namespace beatlas::study
