#pragma once
#include <cstdint>

#include "pipeline/core/grid.h"

namespace beatlas::edges {

/// Smooths the outlines of cavities, LV wall and heart in each slice: Gaussian of their signed
/// distance. Not over phases: early filling bends a wall's path by millimetres between two phases.
/// That horns of a crescent are cut stays: with its area kept, 12 drawn exams had an RV better by
/// .004 in Dice, and surfaces of cine-exam with edges of 4 mm crossed (1.5 % of the heart's
/// triangles those of the RV, .06 without).
void smooth_outlines(ImageCycle<std::uint8_t>& labels, double sigma_mm);

}  // namespace beatlas::edges
