#pragma once
/// What lies on the left ventricle's wall and is hardly brighter than muscle.

#include "pipeline/segment/chambers.h"

namespace beatlas::segment {

/// Fat or liver a little brighter than muscle grows into the LV's wall: noise hides the step
/// between them in any one voxel. Averaged over a patch of the wall, layer by layer away from the
/// cavity, the step shows; what lies beyond it becomes background, in place. Only where the wall
/// borders on nothing else of the heart. Nothing without an LV.
/// @param noise standard deviation of `images`
void strip_outer_layer(const ImageCycle<float>& images, double noise, const Chambers& chambers,
                       ImageCycle<std::uint8_t>& labels);

}  // namespace beatlas::segment
