#pragma once
/// How far labels are what the prior expected before they grew.

#include "pipeline/core/box.h"
#include "pipeline/core/shapes.h"
#include "pipeline/prior/prior.h"
#include "pipeline/segment/ground.h"
#include "pipeline/segment/options.h"

namespace beatlas::segment {

/// What a person told, on the grid of the labels in question.
struct Told {
  const LabelImages& marks;  ///< [phase][voxel], kUnlabelled elsewhere
  const KnownLabels& known;
};

/// What is known is expected. A mark on what the prior had thought otherwise says that its opinion
/// of the slice is not to be heeded: there the labels, which grew from the mark, are what is
/// expected. A mark on what was expected in any case says nothing new.
/// @param labels of the part `box` of the stack that the prior was made of
/// @return [structure][phase][slice of the stack]; slices beyond the box are all 0
[[nodiscard]] Belief belief_in(const prior::PriorCycle& prior,
                               const ImageCycle<std::uint8_t>& labels, const Box& box,
                               const Told& told, const std::vector<Structure>& structures);

/// The same after labels of the stack were painted: in slices that changed they are what is
/// expected.
void believe_painted(const LabelCycle& before, const LabelCycle& after, Belief& belief);

}  // namespace beatlas::segment
