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
  object.finish();
  return scene;
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
