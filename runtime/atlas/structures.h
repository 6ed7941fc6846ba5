#pragma once
/// The anatomical structures an atlas can hold, their names in files and their label numbers.

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace beatlas {

/// `Heart` is everything inside the epicardium, cavities included, pericardial fat excluded.
/// Papillary muscles count as cavity, unless whoever made it chose otherwise.
enum class Structure : std::uint8_t { Heart, LvBlood, RvBlood, LvMyocardium };

inline constexpr std::array kAllStructures{Structure::Heart, Structure::LvBlood, Structure::RvBlood,
                                           Structure::LvMyocardium};

/// "heart", "lv_blood", "rv_blood", "lv_myocardium".
[[nodiscard]] std::string_view structure_name(Structure structure) noexcept;
[[nodiscard]] std::optional<Structure> structure_from_name(std::string_view name) noexcept;

/// Values of label images. A heart voxel is any voxel that is not 0.
enum Label : std::uint8_t {
  kLabelBackground = 0,
  kLabelRvBlood = 1,
  kLabelLvMyocardium = 2,
  kLabelLvBlood = 3,
  kLabelRestOfHeart = 4,
};

/// Whether a voxel of `label` belongs to `structure`.
[[nodiscard]] bool label_in_structure(std::uint8_t label, Structure structure) noexcept;

}  // namespace beatlas
