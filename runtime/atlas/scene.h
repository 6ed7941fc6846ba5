#pragma once
/// What a package of each scene holds, and where: the one rule that the writer follows and the
/// reader's messages quote.

#include <array>
#include <string>
#include <string_view>

#include "runtime/atlas/structures.h"

namespace beatlas::atlas {

/// `Item::kind`: a signed distance of the cycle; the surface of the first phase; how its vertices
/// move through the other phases; the images around the heart, for drawing.
inline constexpr std::string_view kFieldKind = "field";
inline constexpr std::string_view kSurfaceKind = "surface";
inline constexpr std::string_view kMotionKind = "motion";
inline constexpr std::string_view kVolumeKind = "volume";
inline constexpr std::array kKinds{kFieldKind, kSurfaceKind, kMotionKind, kVolumeKind};

/// palpation: the field of the heart, all that touching its outside needs. anatomy: every surface,
/// no field. full: everything. There is one volume, the heart's, and none without images.
inline constexpr std::array<std::string_view, 3> kScenes{"palpation", "anatomy", "full"};

[[nodiscard]] bool is_scene(std::string_view name) noexcept;
[[nodiscard]] bool is_kind(std::string_view name) noexcept;

/// Whether a package of `scene` holds the payload `kind` of `structure`.
[[nodiscard]] bool scene_holds(std::string_view scene, std::string_view kind,
                               Structure structure) noexcept;

/// The scenes that hold it, for messages: "palpation or full".
[[nodiscard]] std::string scenes_that_hold(std::string_view kind, Structure structure);

/// Entry name in the zip: "fields/<structure>.field.zst", "surfaces/<structure>.drc",
/// "surfaces/<structure>.motion", "volumes/<structure>.volume.zst". @pre is_kind(kind)
[[nodiscard]] std::string item_path(std::string_view kind, Structure structure);

}  // namespace beatlas::atlas
