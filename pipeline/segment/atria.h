#pragma once
/// Atria and the root of the aorta, out of what stands on the ventricles.

#include <vector>

#include "pipeline/core/long_axis.h"
#include "pipeline/core/shapes.h"
#include "pipeline/segment/ring.h"

namespace beatlas::segment {

/// Beyond the ventricles blood lies in pools with thin walls between them, through which images
/// blur it. Each pool is what one finds going uphill in depth, distance to the nearest wall,
/// through space and through the cycle (a watershed; necks narrower than most of the smaller pool
/// part two). Which pool is which follows from where it lies beside the LV's axis: the left atrium
/// on it and away from the RV's outflow, the right one behind the RV, the aorta between and in
/// front of them. The pulmonary trunk is rest of heart. Thin slices only: a stack of thick ones
/// shows a slice or two of them.
/// @param images the same part of the exam as `labels`, smoothed; @param axis as ventricle_axis
/// found it; @param labels kLabelRestOfHeart becomes the pool's own label, in place
/// @return the structures that were found, in every phase
[[nodiscard]] std::vector<Structure> part_atria(const ImageCycle<float>& images,
                                                const TissueLevels& levels, const LongAxis& axis,
                                                int end_diastole, ImageCycle<std::uint8_t>& labels);

}  // namespace beatlas::segment
