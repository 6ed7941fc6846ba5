#pragma once
/// What a package of each scene holds, and where: the one rule that the writer follows and the
/// reader's messages quote.

#include <array>
#include <string>
#include <string_view>

#include "runtime/atlas/structures.h"

namespace beatlas::atlas {

/// `Item::kind`: a signed distance of the cycle; a surface's mean over it; how its vertices move
/// through the phases; what its vertices are called and how thick the ventricle's wall is there;
/// the images around the heart, for drawing.
inline constexpr std::string_view kFieldKind = "field";
inline constexpr std::string_view kSurfaceKind = "surface";
inline constexpr std::string_view kMotionKind = "motion";
inline constexpr std::string_view kMapKind = "surface_map";
inline constexpr std::string_view kVolumeKind = "volume";
inline constexpr std::array kKinds{kFieldKind, kSurfaceKind, kMotionKind, kMapKind, kVolumeKind};

/// palpation: the field of the heart, which a finger on its outside touches, and the LV's
/// endocardium with its map, which tells what muscle lies under it. anatomy: every surface and map,
/// no field. full: everything. There is one volume, the heart's, and none without images; maps of
/// lv_blood, lv_myocardium and rv_blood, and none without an LV and an RV.
inline constexpr std::array<std::string_view, 3> kScenes{"palpation", "anatomy", "full"};

[[nodiscard]] bool is_scene(std::string_view name) noexcept;
[[nodiscard]] bool is_kind(std::string_view name) noexcept;

/// Whether there can be a payload `kind` of `structure`.
[[nodiscard]] bool kind_exists(std::string_view kind, Structure structure) noexcept;

/// Whether a package of `scene` holds the payload `kind` of `structure`.
[[nodiscard]] bool scene_holds(std::string_view scene, std::string_view kind,
                               Structure structure) noexcept;

/// The scenes that hold it, for messages: "palpation, anatomy or full".
[[nodiscard]] std::string scenes_that_hold(std::string_view kind, Structure structure);

/// Whether payloads of this kind come in levels of detail: a surface and what goes by its vertices.
[[nodiscard]] bool has_levels(std::string_view kind) noexcept;

/// Entry name in the zip: "fields/<structure>.field.zst", "surfaces/<structure>.drc",
/// "surfaces/<structure>.motion", "maps/<structure>.map.zst", "volumes/<structure>.volume.zst"; of
/// level 1 and coarser "surfaces/<structure>.level1.drc" and the like.
/// @pre is_kind(kind), level >= 0, has_levels(kind) unless level is 0
[[nodiscard]] std::string item_path(std::string_view kind, Structure structure, int level = 0);

}  // namespace beatlas::atlas
