#pragma once
/// What the prior says before anything grows: where the heart is, seeds, and what a label costs.

#include <optional>
#include <string>

#include "pipeline/core/box.h"
#include "pipeline/core/exam.h"
#include "pipeline/core/shapes.h"
#include "pipeline/prior/prior.h"
#include "pipeline/segment/ground.h"

namespace beatlas::segment {

/// The likeliest label of every voxel of the prior's grid, one heart and one left ventricle through
/// space and time: what does not hang together with them is background.
[[nodiscard]] LabelCycle likeliest_labels(const prior::PriorCycle& prior);

/// The box around those labels' heart in the stack, with room for what the prior overlooked; empty
/// if there is none.
[[nodiscard]] Box box_of_heart(const Grid& stack, const LabelCycle& likeliest);

/// Whether the likeliest labels hold a heart that can be one: in some phase the LV has at least the
/// volume of the smallest of the family at the end of its systole, and a wall. Blood that beats
/// without muscle about it is none.
[[nodiscard]] bool holds_heart(const LabelCycle& likeliest);

/// A sentence that names the slices that are labelled after views across them rather than by what
/// the prior sees in themselves; none if there are none.
[[nodiscard]] std::optional<std::string> labelled_after_views(const prior::PriorCycle& prior);

/// Seeds, prices and levels of the part of the stack that `images` are.
/// @param images evenly lit, of a part of the stack's grid
/// @param likeliest of the whole prior  @pre holds_heart(likeliest)
[[nodiscard]] Ground lay_prior_ground(const ImageCycle<float>& images,
                                      const prior::PriorCycle& prior, const LabelCycle& likeliest);

}  // namespace beatlas::segment
