#include "runtime/atlas/structures.h"

#include <algorithm>

namespace beatlas {
namespace {
constexpr std::array<std::string_view, kAllStructures.size()> kNames{
    "heart", "lv_blood", "rv_blood", "lv_myocardium", "la_blood", "ra_blood", "aorta"};
constexpr std::array<std::uint8_t, kAllStructures.size()> kLabels{
    kLabelRestOfHeart, kLabelLvBlood, kLabelRvBlood, kLabelLvMyocardium,
    kLabelLaBlood,     kLabelRaBlood, kLabelAorta};
}  // namespace

std::string_view structure_name(Structure structure) noexcept {
  return kNames[static_cast<std::size_t>(structure)];
}

std::optional<Structure> structure_from_name(std::string_view name) noexcept {
  for (Structure structure : kAllStructures) {
    if (structure_name(structure) == name) return structure;
  }
  return std::nullopt;
}

bool is_beyond_base(Structure structure) noexcept {
  return std::find(kBeyondBase.begin(), kBeyondBase.end(), structure) != kBeyondBase.end();
}

std::uint8_t label_of(Structure structure) noexcept {
  return kLabels[static_cast<std::size_t>(structure)];
}

bool label_in_structure(std::uint8_t label, Structure structure) noexcept {
  return structure == Structure::Heart ? label != kLabelBackground : label == label_of(structure);
}

}  // namespace beatlas
