#pragma once
/// A scene: what a trainer will do with the atlas, and so what the package holds.

#include <string>

#include <nlohmann/json.hpp>

#include "runtime/atlas/manifest.h"

namespace beatlas::cli {

struct Scene {
  std::string content = "full";  ///< palpation, anatomy or full; see runtime/atlas/scene.h
  double stiffness_n_per_m = atlas::Manifest{}.stiffness_n_per_m;  ///< [N/m] 0..1e6
};

/// See schemas/scene.schema.json. @throws Error{InvalidInput} naming the JSON path.
[[nodiscard]] Scene scene_from_json(const nlohmann::json& json);

/// @param name_or_file palpation, anatomy, full, or the name of a JSON file that ends in .json
/// @throws Error{Usage} for another name; Error{InvalidInput} for a file that is no scene.
[[nodiscard]] Scene read_scene(const std::string& name_or_file);

}  // namespace beatlas::cli
