#pragma once
/// Where a technician's seeds say that a ventricle is, it is: which end is its base, and how far it
/// reaches, follow them.

#include <vector>

#include "pipeline/segment/chambers.h"
#include "pipeline/segment/seeds.h"
#include "pipeline/segment/valves.h"

namespace beatlas::segment {

/// Slices at what was taken for the LV's base (its third there) if they are clearly narrower at
/// end-diastole than its other end, ascending; none else. Atria and vessels beyond the base look
/// like an apex to a rule that goes by width, but nobody draws LV blood there.
/// @pre chambers.lv ascending, with the slices that seeds added
[[nodiscard]] std::vector<int> doubted_base(const Chambers& chambers);

/// Slices in which a ventricle is drawn, farthest towards base and apex.
[[nodiscard]] DrawnReach drawn_reach(const Grid& grid, const LabelImages& marks, int base_step);

/// Planes of `ends` that would cut off a slice in which the ventricle is drawn, in the phase in
/// which it is, lie half a gap beyond it instead; `ends.drawn` is `reach`.
void reach_drawn_slices(const DrawnReach& reach, int base_step, VentricleEnds& ends);

}  // namespace beatlas::segment
