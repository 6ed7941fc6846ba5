#include "pipeline/build/scene_plan.h"

#include <algorithm>

#include "runtime/atlas/scene.h"

namespace beatlas::build {

ScenePlan plan_of(const Scene& scene) {
  const auto holds = [&](std::string_view kind, Structure structure) {
    return atlas::scene_holds(scene.content, kind, structure);
  };
  const auto holds_any = [&](std::string_view kind) {
    return std::any_of(kAllStructures.begin(), kAllStructures.end(),
                       [&](Structure structure) { return holds(kind, structure); });
  };
  ScenePlan plan;
  for (const Structure structure : kAllStructures) {
    const bool surface = holds(atlas::kSurfaceKind, structure);
    // Walls of the LV are measured through its muscle.
    const bool of_map = structure == Structure::LvMyocardium && holds_any(atlas::kMapKind);
    if (surface) plan.surfaces.push_back(structure);
    if (surface || of_map || holds(atlas::kFieldKind, structure)) plan.fields.push_back(structure);
    plan.atria = plan.atria || (surface && is_beyond_base(structure));
  }
  plan.volume = holds_any(atlas::kVolumeKind);
  return plan;
}

ScenePlan plan_of_study(const Scene& scene) {
  ScenePlan plan;
  plan.fields.assign(kAllStructures.begin(), kAllStructures.end());
  plan.surfaces = plan.fields;
  plan.atria = true;
  plan.volume = plan_of(scene).volume;
  return plan;
}

}  // namespace beatlas::build
