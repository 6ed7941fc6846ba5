#pragma once
/// The anatomical structures an atlas can hold, their names in files and their label numbers.

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace beatlas {

/// `Heart` is everything inside the epicardium, cavities included, pericardial fat excluded.
/// Papillary muscles count as cavity, unless whoever made it chose otherwise.
/// Atria are their blood, the aorta the lumen of its root, as far as they are in view.
enum class Structure : std::uint8_t {
  Heart,
  LvBlood,
  RvBlood,
  LvMyocardium,
  LaBlood,
  RaBlood,
  Aorta
};

inline constexpr std::array kAllStructures{
    Structure::Heart,   Structure::LvBlood, Structure::RvBlood, Structure::LvMyocardium,
    Structure::LaBlood, Structure::RaBlood, Structure::Aorta};

/// The heart as a whole and its ventricles.
inline constexpr std::array kVentricular{Structure::Heart, Structure::LvBlood, Structure::RvBlood,
                                         Structure::LvMyocardium};

/// What stands on the ventricles. It is drawn, but has no field of its own in a package: a finger
/// feels it as a part of the heart.
inline constexpr std::array kBeyondBase{Structure::LaBlood, Structure::RaBlood, Structure::Aorta};
[[nodiscard]] bool is_beyond_base(Structure structure) noexcept;

/// "heart", "lv_blood", "rv_blood", "lv_myocardium", "la_blood", "ra_blood", "aorta".
[[nodiscard]] std::string_view structure_name(Structure structure) noexcept;
[[nodiscard]] std::optional<Structure> structure_from_name(std::string_view name) noexcept;

/// Values of label images. A heart voxel is any voxel that is not 0.
enum Label : std::uint8_t {
  kLabelBackground = 0,
  kLabelRvBlood = 1,
  kLabelLvMyocardium = 2,
  kLabelLvBlood = 3,
  kLabelRestOfHeart = 4,
  kLabelLaBlood = 5,
  kLabelRaBlood = 6,
  kLabelAorta = 7,
};
inline constexpr std::uint8_t kLastLabel = kLabelAorta;
/// Of given labels: nobody said what is there. No package holds it.
inline constexpr std::uint8_t kLabelUnknown = 255;
/// For messages.
inline constexpr const char* kLabelNumbers =
    "0 background, 1 RV blood, 2 LV myocardium, 3 LV blood, 4 rest of heart, 5 LA blood, 6 RA "
    "blood, 7 aorta";

/// The label that is the structure's own; of the heart kLabelRestOfHeart.
[[nodiscard]] std::uint8_t label_of(Structure structure) noexcept;

/// The same without a difference between atria, aorta and the rest of the heart.
[[nodiscard]] constexpr std::uint8_t ventricles_apart(std::uint8_t label) noexcept {
  return label > kLabelRestOfHeart && label <= kLastLabel ? std::uint8_t{kLabelRestOfHeart} : label;
}

/// Whether a voxel of `label` belongs to `structure`.
[[nodiscard]] bool label_in_structure(std::uint8_t label, Structure structure) noexcept;

}  // namespace beatlas
