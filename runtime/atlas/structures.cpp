#include "runtime/atlas/structures.h"

namespace beatlas {
namespace {
constexpr std::array<std::string_view, kAllStructures.size()> kNames{"heart", "lv_blood",
                                                                     "rv_blood", "lv_myocardium"};
}

std::string_view structure_name(Structure structure) noexcept {
  return kNames[static_cast<std::size_t>(structure)];
}

std::optional<Structure> structure_from_name(std::string_view name) noexcept {
  for (Structure structure : kAllStructures) {
    if (structure_name(structure) == name) return structure;
  }
  return std::nullopt;
}

bool label_in_structure(std::uint8_t label, Structure structure) noexcept {
  switch (structure) {
    case Structure::Heart:
      return label != kLabelBackground;
    case Structure::LvBlood:
      return label == kLabelLvBlood;
    case Structure::RvBlood:
      return label == kLabelRvBlood;
    case Structure::LvMyocardium:
      return label == kLabelLvMyocardium;
  }
  return false;
}

}  // namespace beatlas
