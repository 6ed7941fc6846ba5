#pragma once
/// What a person says, by labels of some phases and by seeds: it holds, and prior and images tell
/// the rest.
///
/// A structure that a known phase has anywhere is known there as a whole: where its label is not,
/// it is not. A structure that the phase has nowhere was not drawn, and kLabelUnknown was left
/// open.

#include "pipeline/core/box.h"
#include "pipeline/segment/ground.h"
#include "pipeline/segment/options.h"

namespace beatlas::segment {

/// The heart's box made to hold the known labels, with a margin.
[[nodiscard]] Box box_with_labels(const Grid& grid, const Box& box, const KnownLabels& known);

/// The known labels in a box.
[[nodiscard]] KnownLabels crop(const KnownLabels& known, const Box& box);

/// What was marked wins over what a prior is sure of: within a ball of twice the radius nothing
/// else is seeded, and the label marked costs least. Elsewhere the ground stays as it was.
/// @param marks what seeds drew on the grid, kUnlabelled elsewhere
void hold_marks(const Grid& grid, const std::vector<Seed>& seeds, const LabelImages& marks,
                Ground& ground);

/// Makes seeds of what is known, and what is known not to be there as dear as can be.
/// @param known on the ground's grid, without a difference between atria and the rest of the heart
void hold_known(const KnownLabels& known, Ground& ground);

/// Sets the probability of a structure to 1 or 0 wherever a known phase tells that it is there or
/// not.
/// @param probability [voxel] on the known labels' grid
void expect_known(const KnownLabels& known, int phase, Structure structure,
                  std::vector<float>& probability);

/// Puts what is known into labels that grew beside it: cavity that is known to be none is the LV's
/// wall where that is not known, else background.
void put_known(const KnownLabels& known, ImageCycle<std::uint8_t>& labels);

}  // namespace beatlas::segment
