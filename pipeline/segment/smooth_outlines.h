#pragma once
#include <cstdint>

#include "pipeline/core/grid.h"

namespace beatlas::segment {

/// Smooths the outlines of cavities, LV wall and heart in each slice: Gaussian of their signed
/// distance. Not over phases: early filling bends a wall's path by millimetres between two phases.
void smooth_outlines(ImageCycle<std::uint8_t>& labels, double sigma_mm);

}  // namespace beatlas::segment
