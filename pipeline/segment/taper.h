#pragma once
/// Outlines of thick slices from those of the slices beside them. A ventricle is convex, so toward
/// its apex an outline lies within the straight continuation of the next two. About its base it is
/// as wide as ever, so where a slice shows no outline of its own, that of the next one, moved as
/// the ventricle leans, is the best there is.

#include "pipeline/segment/chambers.h"
#include "pipeline/segment/valves.h"

namespace beatlas::segment {

/// From the LV's most apical slice on: fat and liver, which blur into the apical slices, are taken
/// off what reaches beyond the continuation of the slices above. An LV cavity that was seen in no
/// ring becomes muscle. Nothing in thin slices.
void bound_apex(const Chambers& chambers, ImageCycle<std::uint8_t>& labels);

/// Slices whose centre lies just below the base plane show ventricle and atrium at once: they get
/// the outline of the slice below, but for lung. Nothing without base planes, and nothing of the
/// heart's outside.
void redraw_mixed_slices(const ImageCycle<float>& images, const Chambers& chambers,
                         const VentricleEnds& ends, ImageCycle<std::uint8_t>& labels);

/// Slices whose centre lies just beyond a ventricle's base plane still show some of it beside its
/// atrium: of that, what the next slice beyond shows as heart too is the atrium, the rest is not of
/// the heart. Where the slices tell the plane themselves, not where views do.
void clear_mixed_atria(const Chambers& chambers, const VentricleEnds& ends,
                       ImageCycle<std::uint8_t>& labels);

/// The same labels, with the ventricles carried on into the slices whose centre lies just beyond
/// their base plane: of the shape that ends there, not of those voxels.
[[nodiscard]] ImageCycle<std::uint8_t> continued_to_base(const ImageCycle<float>& images,
                                                         const Chambers& chambers,
                                                         const VentricleEnds& ends,
                                                         const ImageCycle<std::uint8_t>& labels);

}  // namespace beatlas::segment
