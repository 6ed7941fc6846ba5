#include <array>
#include <cstdio>

#include "pipeline/study/files.h"
#include "pipeline/study/ply.h"
#include "pipeline/study/stage_files.h"
#include "runtime/base/error.h"
#include "runtime/base/json_object.h"

namespace beatlas::study {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

std::string mesh_name(Structure structure, std::size_t phase) {
  std::array<char, 80> name{};
  std::snprintf(name.data(), name.size(), "%s_%03zu.ply", structure_name(structure).data(), phase);
  return name.data();
}

SurfaceCycle read_cycle(const fs::path& folder, const json& value, const std::string& path) {
  JsonObject object(value, path);
  std::string name;
  object.read("structure", name);
  const std::optional<Structure> structure = structure_from_name(name);
  if (!structure) throw_invalid(path + "/structure is not the name of a structure");
  int phases = 0;
  object.read("phases", phases, 1, 10000);
  object.finish();
  SurfaceCycle cycle;
  cycle.structure = *structure;
  for (std::size_t phase = 0; phase < static_cast<std::size_t>(phases); ++phase) {
    const std::string file = mesh_name(*structure, phase);
    TriangleMesh mesh = read_ply(folder / file);
    if (phase == 0) cycle.triangles = mesh.triangles;
    if (mesh.triangles != cycle.triangles ||
        (phase > 0 && mesh.vertices.size() != cycle.positions[0].size())) {
      throw_invalid("mesh/" + file + " has other triangles than mesh/" + mesh_name(*structure, 0) +
                    "; vertices may be moved by hand, but all phases share one connectivity");
    }
    cycle.positions.push_back(std::move(mesh.vertices));
  }
  return cycle;
}

}  // namespace

FileList write_surfaces(const fs::path& study, const std::vector<SurfaceCycle>& surfaces) {
  const fs::path folder = study / "mesh";
  make_folder(folder);
  FileList files{"mesh/mesh.json"};
  json content{{"surfaces", json::array()}};
  for (const SurfaceCycle& cycle : surfaces) {
    for (std::size_t phase = 0; phase < cycle.positions.size(); ++phase) {
      const std::string name = mesh_name(cycle.structure, phase);
      write_ply(folder / name, {cycle.positions[phase], cycle.triangles});
      files.push_back("mesh/" + name);
    }
    content["surfaces"].push_back(
        {{"structure", structure_name(cycle.structure)}, {"phases", cycle.positions.size()}});
  }
  write_json(folder / "mesh.json", content);
  return files;
}

std::vector<SurfaceCycle> read_surfaces(const fs::path& study) {
  const fs::path folder = study / "mesh";
  const fs::path index = folder / "mesh.json";
  const json content = read_json(index);
  try {
    JsonObject object(content, "");
    const json& list = object.at("surfaces");
    if (!list.is_array()) throw_invalid("/surfaces must be a list");
    std::vector<SurfaceCycle> surfaces;
    for (std::size_t at = 0; at < list.size(); ++at) {
      surfaces.push_back(read_cycle(folder, list[at], "/surfaces/" + std::to_string(at)));
    }
    object.finish();
    return surfaces;
  } catch (const Error& error) {
    throw said_of(index, error);
  }
}

}  // namespace beatlas::study
