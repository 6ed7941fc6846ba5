#include "pipeline/cli/scene.h"

#include "pipeline/study/files.h"
#include "runtime/atlas/scene.h"
#include "runtime/base/error.h"
#include "runtime/base/json_object.h"

namespace beatlas::cli {

Scene scene_from_json(const nlohmann::json& json) {
  Scene scene;
  JsonObject object(json, "");
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
    const nlohmann::json& edges = object.at("surface_edges_mm");
    if (!edges.is_array() || edges.empty() || edges.size() > atlas::kMaxSurfaceLevels) {
      throw_invalid("/surface_edges_mm must be a list of 1 to " +
                    std::to_string(atlas::kMaxSurfaceLevels) + " entries");
    }
    for (const nlohmann::json& edge : edges) {
      const double mm = edge.is_number() ? edge.get<double>() : 0;
      const double least = scene.surface_edges_mm.empty() ? 0.5 : scene.surface_edges_mm.back();
      if (!(mm >= 0.5 && mm <= 10 && (scene.surface_edges_mm.empty() || mm > least))) {
        throw_invalid("/surface_edges_mm/" + std::to_string(scene.surface_edges_mm.size()) +
                      " must be a number from 0.5 to 10 and more than the one before");
      }
      scene.surface_edges_mm.push_back(mm);
    }
  }
  object.finish();
  return scene;
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

}  // namespace beatlas::cli
