#pragma once
#include <cstdint>

#include "pipeline/core/grid.h"

namespace beatlas::segment {

/// Smooths the outlines of cavities, LV wall and heart in each slice: Gaussian of their signed
/// distance. Cavities with thin walls keep their area, for smoothing cuts the horns of a crescent
/// (volume of the RV at end-diastole over the truth's, mean of 12 drawn exams: .903, and .919 so).
/// Not over phases: early filling bends a wall's path by millimetres between two phases.
void smooth_outlines(ImageCycle<std::uint8_t>& labels, double sigma_mm);

}  // namespace beatlas::segment
