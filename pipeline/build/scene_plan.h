#pragma once
/// What a build makes for a scene, known before anything is made.

#include <vector>

#include "pipeline/build/scene.h"

namespace beatlas::build {

/// Structures are in order of kAllStructures; of these a heart may lack some.
struct ScenePlan {
  /// Whose distances are made: those that are felt, and those from which surfaces and maps are.
  std::vector<Structure> fields;
  std::vector<Structure> surfaces;
  bool atria = false;   ///< atria and aorta are told apart from the rest of the heart
  bool volume = false;  ///< the images around the heart are kept for the package
};

/// Of a package alone.
[[nodiscard]] ScenePlan plan_of(const Scene& scene);

/// Of a study, which can be packed again for any scene and whose report shows all: every field and
/// surface, atria too.
[[nodiscard]] ScenePlan plan_of_study(const Scene& scene);

}  // namespace beatlas::build
