#pragma once
/// Papillary muscles as part of the wall: labels take them into the cavity, as most do; here they
/// are taken out of it again.

#include "pipeline/core/shapes.h"
#include "pipeline/tissue/levels.h"

namespace beatlas::edges {

/// Of LV blood, what is as dark as muscle over a disc of 2 mm in radius becomes LV muscle; the rim
/// of voxels that are half wall is thinner than that and stays.
void papillary_muscles_to_wall(const ImageCycle<float>& images, const tissue::TissueLevels& levels,
                               ImageCycle<std::uint8_t>& labels);

}  // namespace beatlas::edges
