#pragma once
/// The parts of a phantom whose surfaces are known in closed form.

#include <array>
#include <cstdint>
#include <string_view>

#include "runtime/atlas/structures.h"

namespace beatlas::phantom {

/// The first four are the structures of an atlas, with the same numbers.
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

/// What functions take: a part, or the structure of an atlas that it is.
class PartArgument {
 public:
  constexpr PartArgument(Part part) : part_(part) {}  // NOLINT(google-explicit-constructor)
  constexpr PartArgument(Structure structure)         // NOLINT(google-explicit-constructor)
      : part_(static_cast<Part>(structure)) {}
  constexpr operator Part() const { return part_; }  // NOLINT(google-explicit-constructor)

 private:
  Part part_;
};

/// "heart", "lv_blood", ..., "papillary_muscles", "pericardium".
[[nodiscard]] std::string_view part_name(Part part) noexcept;

}  // namespace beatlas::phantom
