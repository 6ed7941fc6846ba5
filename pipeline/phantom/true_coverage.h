#pragma once
#include "pipeline/core/shapes.h"
#include "pipeline/core/stage_context.h"
#include "pipeline/phantom/phantom.h"

namespace beatlas::phantom {

/// Share 0..1 of every voxel, as thick as slices lie apart, in each structure that the phantom has,
/// at the phases' nominal times; as labels it knows of no degradation. On the part of the imaging
/// grid that holds the heart of every phase. Error as `cover`'s, 0.001 away from creases.
[[nodiscard]] CoverageCycle true_coverage(const Phantom& phantom, StageContext& context);

}  // namespace beatlas::phantom
