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

bool kind_exists(std::string_view kind, Structure structure) noexcept {
  if (kind == kVolumeKind) return structure == Structure::Heart;
  if (kind == kMapKind) {
    return structure == Structure::LvBlood || structure == Structure::LvMyocardium ||
           structure == Structure::RvBlood;
  }
  if (kind == kFieldKind) return !is_beyond_base(structure);
  return is_kind(kind);
}

bool scene_holds(std::string_view scene, std::string_view kind, Structure structure) noexcept {
  if (!kind_exists(kind, structure)) return false;
  if (scene == "full") return true;
  const bool of_surface = has_levels(kind);
  if (scene == "palpation") {
    return kind == kFieldKind ? structure == Structure::Heart
                              : of_surface && structure == Structure::LvBlood;
  }
  return scene == "anatomy" && of_surface;
}

std::string scenes_that_hold(std::string_view kind, Structure structure) {
  std::string list;
  std::string last;
  for (std::string_view scene : kScenes) {
    if (!scene_holds(scene, kind, structure)) continue;
    if (!last.empty()) list += (list.empty() ? "" : ", ") + last;
    last = scene;
  }
  return list.empty() ? last : list + " or " + last;
}

bool has_levels(std::string_view kind) noexcept {
  return kind == kSurfaceKind || kind == kMotionKind || kind == kMapKind;
}

std::string item_path(std::string_view kind, Structure structure, int level) {
  assert(is_kind(kind) && level >= 0 && (level == 0 || has_levels(kind)));
  std::string name(structure_name(structure));
  if (level > 0) name += ".level" + std::to_string(level);
  if (kind == kFieldKind) return "fields/" + name + ".field.zst";
  if (kind == kVolumeKind) return "volumes/" + name + ".volume.zst";
  if (kind == kMapKind) return "maps/" + name + ".map.zst";
  if (kind == kMotionKind) return "surfaces/" + name + ".motion";
  return "surfaces/" + name + ".drc";
}

}  // namespace beatlas::atlas
