#pragma once
/// Outlines of thick slices from those of the slices beside them. A ventricle is convex, so along
/// its axis an outline lies within the straight continuation of the next two; where a slice shows
/// no outline of its own that continuation is the best there is.

#include "pipeline/segment/chambers.h"
#include "pipeline/segment/valves.h"

namespace beatlas::segment {

/// From the LV's most apical slice on: fat and liver, which blur into the apical slices, are taken
/// off what reaches beyond the continuation of the slices above. An LV cavity that was seen in no
/// ring becomes muscle. Nothing in thin slices.
void bound_apex(const Chambers& chambers, ImageCycle<std::uint8_t>& labels);

/// Slices that the base plane passes through, half or more on the ventricle's side, show the sum of
/// ventricle and atrium: they get the continuation of the slices below. Nothing in thin slices, and
/// nothing of the heart's outside.
void redraw_mixed_slices(const Chambers& chambers, const VentricleEnds& ends,
                         ImageCycle<std::uint8_t>& labels);

}  // namespace beatlas::segment
