#pragma once
/// Where valves are thought to end structures in stacks of thick slices, between two of them.

#include <map>

#include "pipeline/core/shapes.h"

namespace beatlas::segment {

/// Planes of valves, between the slices that labels tell; see ValvePlane.
/// @param base_step +1 if the base lies towards larger k, -1 if smaller
[[nodiscard]] std::map<Structure, ValvePlane> estimated_valve_planes(
    const ImageCycle<std::uint8_t>& labels, int base_step);

/// Most basal slice with the structure in a phase; -1 if it has none.
[[nodiscard]] int most_basal(const ImageCycle<std::uint8_t>& labels, std::size_t phase,
                             Structure structure, int base_step);

/// How slices lie to the LV.
struct BaseSide {
  /// +1 if the base lies towards larger k, -1 if smaller: where atria and aorta are in view on
  /// their side, else on the side of the wall on which the cavity is open; where no wall tells,
  /// where the cavity (without one, the heart) is larger. 0: nothing tells.
  int step = 0;
  bool across = true;  ///< they cut it across rather than along
};
[[nodiscard]] BaseSide base_side(const LabelCycle& labels);

}  // namespace beatlas::segment
