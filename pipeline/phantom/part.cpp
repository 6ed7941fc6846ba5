#include "pipeline/phantom/part.h"

namespace beatlas::phantom {

std::string_view part_name(Part part) noexcept {
  switch (part) {
    case Part::RvWall:
      return "rv_wall";
    case Part::LaBlood:
      return "la_blood";
    case Part::RaBlood:
      return "ra_blood";
    case Part::Aorta:
      return "aorta";
    case Part::PapillaryMuscles:
      return "papillary_muscles";
    case Part::Pericardium:
      return "pericardium";
    default:
      return structure_name(static_cast<Structure>(part));
  }
}

}  // namespace beatlas::phantom
