#pragma once
/// A scene: what a trainer will do with the atlas, and so what the package holds.

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "runtime/atlas/manifest.h"
#include "runtime/atlas/structures.h"

namespace beatlas::build {

struct Scene {
  std::string content = "full";  ///< palpation, anatomy or full; see runtime/atlas/scene.h
  double stiffness_n_per_m = atlas::Manifest{}.stiffness_n_per_m;  ///< [N/m] 0..1e6
  /// [mm] 0.5..10, rising: edges of the levels of detail of its surfaces. Empty: as the mesh stage
  /// made them and, but for palpation, kCoarseEdgeMm where that is coarser by half.
  std::vector<double> surface_edges_mm = {};
  /// That a package must have; none: what its content shows and feels, see structures_needed.
  std::vector<Structure> structures = {};
};
inline constexpr double kCoarseEdgeMm = 4;

/// Those of the scene, or where it names none those of its content.
/// @param made_mm mesh::triangle_edge_mm of the mesh stage
[[nodiscard]] std::vector<double> surface_edges_mm(const Scene& scene, double made_mm);

/// The structures without which a study is not what the scene is for: those that the scene names;
/// else those of which it holds a payload, and whose walls its maps tell of, but not atria and
/// aorta, which thick slices do not show. In order of kAllStructures.
/// @param every_phase_given labels of every phase were given, so nothing was looked for: what they
/// hold is what there is, and only a scene that names structures needs more of them than a heart
[[nodiscard]] std::vector<Structure> structures_needed(const Scene& scene, bool every_phase_given);

[[nodiscard]] bool is_among(Structure structure, const std::vector<Structure>& list);

/// As a study's record keeps it.
[[nodiscard]] nlohmann::json scene_to_json(const Scene& scene);

/// See schemas/scene.schema.json. @throws Error{InvalidInput} naming the JSON path.
[[nodiscard]] Scene scene_from_json(const nlohmann::json& json);

/// @param name_or_file palpation, anatomy, full, or the name of a JSON file that ends in .json
/// @throws Error{Usage} for another name; Error{InvalidInput} for a file that is no scene.
[[nodiscard]] Scene read_scene(const std::string& name_or_file);

}  // namespace beatlas::build
