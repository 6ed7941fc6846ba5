#include "pipeline/build/scene.h"

#include <algorithm>
#include <optional>

#include "pipeline/study/files.h"
#include "runtime/atlas/scene.h"
#include "runtime/base/error.h"
#include "runtime/base/json_object.h"

namespace beatlas::build {
namespace {

std::vector<double> read_surface_edges(const nlohmann::json& edges) {
  if (!edges.is_array() || edges.empty() || edges.size() > atlas::kMaxSurfaceLevels) {
    throw_invalid("/surface_edges_mm must be a list of 1 to " +
                  std::to_string(atlas::kMaxSurfaceLevels) + " entries");
  }
  std::vector<double> out;
  for (const nlohmann::json& edge : edges) {
    const double mm = edge.is_number() ? edge.get<double>() : 0;
    if (!(mm >= 0.5 && mm <= 10 && (out.empty() || mm > out.back()))) {
      throw_invalid("/surface_edges_mm/" + std::to_string(out.size()) +
                    " must be a number from 0.5 to 10 and more than the one before");
    }
    out.push_back(mm);
  }
  return out;
}

std::vector<Structure> read_structures(const nlohmann::json& names) {
  if (!names.is_array() || names.empty()) {
    throw_invalid("/structures must be a list of one structure or more");
  }
  std::vector<Structure> out;
  for (std::size_t at = 0; at < names.size(); ++at) {
    const auto structure =
        names[at].is_string() ? structure_from_name(names[at].get<std::string>()) : std::nullopt;
    if (!structure || is_among(*structure, out)) {
      throw_invalid("/structures/" + std::to_string(at) +
                    " must be the name of a structure, and of another than those before: heart, "
                    "lv_blood, rv_blood, lv_myocardium, la_blood, ra_blood or aorta");
    }
    out.push_back(*structure);
  }
  return out;
}

}  // namespace

bool is_among(Structure structure, const std::vector<Structure>& list) {
  return std::find(list.begin(), list.end(), structure) != list.end();
}

Scene scene_from_json(const nlohmann::json& scene_json) {
  Scene scene;
  JsonObject object(scene_json, "");
  object.read("content", scene.content);
  if (!atlas::is_scene(scene.content)) {
    throw_invalid("/content must be palpation, anatomy or full");
  }
  if (object.has("material")) {
    JsonObject material(object.at("material"), "/material");
    material.read("stiffness_n_per_m", scene.stiffness_n_per_m, 0, 1e6);
    material.finish();
  }
  if (object.has("surface_edges_mm")) {
    scene.surface_edges_mm = read_surface_edges(object.at("surface_edges_mm"));
  }
  if (object.has("structures")) {
    scene.structures = read_structures(object.at("structures"));
  }
  object.finish();
  return scene;
}

nlohmann::json scene_to_json(const Scene& scene) {
  nlohmann::json out{{"content", scene.content},
                     {"stiffness_n_per_m", scene.stiffness_n_per_m},
                     {"surface_edges_mm", scene.surface_edges_mm}};
  for (const Structure structure : scene.structures) {
    out["structures"].push_back(structure_name(structure));
  }
  return out;
}

std::vector<Structure> structures_needed(const Scene& scene, bool every_phase_given) {
  std::vector<Structure> out;
  for (const Structure structure : kAllStructures) {
    bool needed = false;
    if (!scene.structures.empty()) {
      needed = is_among(structure, scene.structures);
    } else if (every_phase_given) {
      needed = structure == Structure::Heart;
    } else if (!is_beyond_base(structure)) {
      const bool has_map =
          std::any_of(kAllStructures.begin(), kAllStructures.end(), [&](Structure mapped) {
            return atlas::scene_holds(scene.content, atlas::kMapKind, mapped);
          });
      // A map tells the thickness of the LV's muscle, and the septum by the RV beside it.
      const bool of_map =
          has_map && (structure == Structure::RvBlood || structure == Structure::LvMyocardium);
      needed = of_map || atlas::scene_holds(scene.content, atlas::kFieldKind, structure) ||
               atlas::scene_holds(scene.content, atlas::kSurfaceKind, structure);
    }
    if (needed) out.push_back(structure);
  }
  return out;
}

std::vector<double> surface_edges_mm(const Scene& scene, double made_mm) {
  if (!scene.surface_edges_mm.empty()) return scene.surface_edges_mm;
  constexpr double kCoarserBy = 1.5;
  if (scene.content == "palpation" || made_mm * kCoarserBy > kCoarseEdgeMm) return {made_mm};
  return {made_mm, kCoarseEdgeMm};
}

Scene read_scene(const std::string& name_or_file) {
  if (atlas::is_scene(name_or_file)) {
    Scene scene;
    scene.content = name_or_file;
    return scene;
  }
  const std::filesystem::path file(name_or_file);
  if (file.extension() != ".json") {
    throw Error(
        ErrorCode::Usage,
        "--scene must be palpation, anatomy, full or a .json file, not '" + name_or_file + "'");
  }
  const nlohmann::json content = study::read_json(file);
  try {
    return scene_from_json(content);
  } catch (const Error& error) {
    throw error.with_context(file.string());
  }
}

}  // namespace beatlas::build
