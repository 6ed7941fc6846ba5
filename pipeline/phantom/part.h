#pragma once
/// The parts of a phantom whose surfaces are known in closed form.

#include <array>
#include <cstdint>
#include <string_view>

#include "runtime/atlas/structures.h"

namespace beatlas::phantom {

enum class Part : std::uint8_t {
  Heart,         ///< filled: chambers, walls and the root of the aorta; without pericardial fat
  LvBlood,       ///< papillary muscles included
  RvBlood,       ///
  LvMyocardium,  ///< without papillary muscles
  RvWall,        ///< free wall
  LaBlood,
  RaBlood,
  Aorta,             ///< lumen of the root
  PapillaryMuscles,  ///< in the LV's cavity
  Pericardium,       ///< the heart with the fat over its ventricles, filled
};

inline constexpr std::array kAllParts{
    Part::Heart,   Part::LvBlood, Part::RvBlood, Part::LvMyocardium,     Part::RvWall,
    Part::LaBlood, Part::RaBlood, Part::Aorta,   Part::PapillaryMuscles, Part::Pericardium};

/// The part that a structure of an atlas is.
[[nodiscard]] constexpr Part part_of(Structure structure) {
  constexpr std::array kParts{Part::Heart,   Part::LvBlood, Part::RvBlood, Part::LvMyocardium,
                              Part::LaBlood, Part::RaBlood, Part::Aorta};
  static_assert(kParts.size() == kAllStructures.size());
  return kParts[static_cast<std::size_t>(structure)];
}

/// What functions take: a part, or the structure of an atlas that it is.
class PartArgument {
 public:
  constexpr PartArgument(Part part) : part_(part) {}  // NOLINT(google-explicit-constructor)
  constexpr PartArgument(Structure structure)         // NOLINT(google-explicit-constructor)
      : part_(part_of(structure)) {}
  constexpr operator Part() const { return part_; }  // NOLINT(google-explicit-constructor)

 private:
  Part part_;
};

/// "heart", "lv_blood", ..., "papillary_muscles", "pericardium".
[[nodiscard]] std::string_view part_name(Part part) noexcept;

}  // namespace beatlas::phantom
