#pragma once
/// In which tone an exam is shown to the network: the exponent of its brightness. Scanners,
/// sequences and contrast agents put muscle at any share of the blood's signal, so which tone tells
/// the two apart best is an unknown of the exam.

#include "pipeline/prior/prior.h"
#include "pipeline/prior/slices.h"

namespace beatlas::prior {

/// How sure the network is of what it saw in a window: the Dice that it expects, between where a
/// structure is likeliest and where it is, in the mean of LV blood, LV muscle and RV blood. 0..1; 0
/// for a structure that it saw nowhere.
/// @param looked other phases than those that were looked at are empty
[[nodiscard]] double expected_dice(const PriorCycle& looked, const Window& window);

}  // namespace beatlas::prior
