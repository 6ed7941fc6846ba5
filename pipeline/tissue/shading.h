#pragma once
/// What the coil and the breath-holds do to brightness: a smooth field over the whole stack, and a
/// gain for each slice.

#include <vector>

#include "pipeline/tissue/tissue.h"

namespace beatlas::tissue {

/// Factor of every voxel by which shading multiplies its signal, on average 1 (in the logarithm)
/// where there is signal. From the mean over the cycle of what does not move: a smooth field
/// spreads each tissue's peak in the histogram of logarithms, and the polynomial of degree 2 is
/// found that draws each voxel to the peak beside it (the principle of Sled et al. 1998, by mean
/// shift). A field that spreads by less than 15 % cannot be told from anatomy, and is taken as
/// none. A slice's gain is the median step from slice to slice that is left, where it exceeds 4 %.
[[nodiscard]] std::vector<float> find_shading(const Grid& grid, const TemporalStats& stats);

/// The images divided by the shading.
[[nodiscard]] ImageCycle<float> without_shading(const ImageCycle<float>& images,
                                                const std::vector<float>& shading);

}  // namespace beatlas::tissue
