#include "runtime/atlas/scene.h"

#include <algorithm>
#include <cassert>

namespace beatlas::atlas {

bool is_scene(std::string_view name) noexcept {
  return std::find(kScenes.begin(), kScenes.end(), name) != kScenes.end();
}

bool is_kind(std::string_view name) noexcept {
  return std::find(kKinds.begin(), kKinds.end(), name) != kKinds.end();
}

bool scene_holds(std::string_view scene, std::string_view kind, Structure structure) noexcept {
  if (kind == kVolumeKind && structure != Structure::Heart) return false;
  if (scene == "full") return true;
  if (scene == "palpation") return kind == kFieldKind && structure == Structure::Heart;
  if (scene == "anatomy") return kind == kSurfaceKind || kind == kMotionKind;
  return false;
}

std::string scenes_that_hold(std::string_view kind, Structure structure) {
  std::string list;
  for (std::string_view scene : kScenes) {
    if (!scene_holds(scene, kind, structure)) continue;
    if (!list.empty()) list += " or ";
    list += scene;
  }
  return list;
}

std::string item_path(std::string_view kind, Structure structure) {
  assert(is_kind(kind));
  const std::string name(structure_name(structure));
  if (kind == kFieldKind) return "fields/" + name + ".field.zst";
  if (kind == kVolumeKind) return "volumes/" + name + ".volume.zst";
  if (kind == kMotionKind) return "surfaces/" + name + ".motion";
  return "surfaces/" + name + ".drc";
}

}  // namespace beatlas::atlas
