#pragma once
/// Labels of a person in some phases, beside a prior: they hold where they tell something, and the
/// prior and the images tell the rest.
///
/// A structure that a known phase has anywhere is known there as a whole: where its label is not,
/// it is not. A structure that the phase has nowhere was not drawn, and kLabelUnknown was left
/// open.

#include "pipeline/segment/prior_ground.h"
#include "pipeline/segment/segment.h"

namespace beatlas::segment {

/// Makes seeds of what is known, and what is known not to be there as dear as can be.
/// @param known on the ground's grid, without a difference between atria and the rest of the heart
void hold_known(const KnownLabels& known, PriorGround& ground);

/// Puts what is known into labels that grew beside it: cavity that is known to be none is the LV's
/// wall where that is not known, else background.
void put_known(const KnownLabels& known, ImageCycle<std::uint8_t>& labels);

}  // namespace beatlas::segment
