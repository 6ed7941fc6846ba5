#pragma once
/// The left ventricle's long axis and its base plane, in a stack of thin slices of any direction.

#include <optional>

#include "pipeline/core/long_axis.h"

namespace beatlas::segment {

struct Chambers;

/// The stack is cut again across the ventricle, and the ring of muscle followed from its middle to
/// where it opens (less than half of the rays meet a wall: the technicians' rule), in every phase.
/// The tricuspid valve opens into no such ring: its plane lies with the LV's at end-diastole and
/// descends with it, by `tricuspid_excursion_mm` scaled as in valves.h.
/// The apex is a first guess, the same in every phase; ventricle_ends.h places it.
/// None without a left ventricle, in thick slices, or where the ring cannot be followed.
[[nodiscard]] std::optional<LongAxis> find_long_axis(const ImageCycle<float>& images,
                                                     const Chambers& chambers,
                                                     double tricuspid_excursion_mm);

/// The same images in slices across the axis, from below the apex to beyond the atria: there the
/// ventricles look as chambers.h knows them, however the stack was cut. Linear in space, 0 outside.
[[nodiscard]] ImageCycle<float> across_axis(const ImageCycle<float>& images, const LongAxis& axis);

}  // namespace beatlas::segment
