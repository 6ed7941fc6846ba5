#pragma once
/// Smoothing that adapts to the noise and keeps edges.

#include "pipeline/core/grid.h"

namespace beatlas::tissue {

/// Diffusion in space and (cyclic) time whose conductance falls where neighbours differ by more
/// than noise makes them differ (Perona and Malik 1990, their second function). Noise falls to
/// about a third; an edge of four times the noise loses less than a tenth of its height.
/// @param noise standard deviation; 0: the images as they are
/// @param phase_step_mm what a step to the next phase counts as: what moves that far between two
/// phases is not to be mixed
[[nodiscard]] ImageCycle<float> denoised(const ImageCycle<float>& images, double noise,
                                         double phase_step_mm);

}  // namespace beatlas::tissue
