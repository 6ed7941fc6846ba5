#pragma once
/// How far labels are what the prior expected before they grew.

#include "pipeline/core/shapes.h"
#include "pipeline/prior/prior.h"
#include "pipeline/segment/box.h"

namespace beatlas::segment {

/// Whether a person told something of a slice (of the part) in a phase.
using Told = std::vector<std::vector<bool>>;

/// Of slices of which a person told something the labels are what is expected.
/// @param labels of the part `box` of the stack that the prior was made of
/// @return [structure][phase][slice of the stack]; slices beyond the box are all 0
[[nodiscard]] Belief belief_in(const prior::PriorCycle& prior,
                               const ImageCycle<std::uint8_t>& labels, const Box& box,
                               const Told& told, const std::vector<Structure>& structures);

/// The same after labels of the stack were painted: in slices that changed they are what is
/// expected.
void believe_painted(const LabelCycle& before, const LabelCycle& after, Belief& belief);

}  // namespace beatlas::segment
