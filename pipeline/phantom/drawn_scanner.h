#pragma once
/// What a scanner makes of a stack through a heart of the family. Beside drawn_signal.h, which
/// shows single slices of 2 mm to a network, voxels here have a size, a profile and neighbours.

#include "pipeline/core/exam.h"
#include "pipeline/core/stage_context.h"
#include "pipeline/phantom/drawn_scene.h"

namespace beatlas::phantom {

/// How a voxel averages what lies about it.
enum class VoxelShape {
  Box,      ///< evenly over its slice's thickness and its pixel, then little blur
  Profile,  ///< by a slice profile with tails; more blur, ringing, fine trabeculae: nothing that
            ///< the pipeline inverts
};

/// Whole counts of every voxel and frame. Blood has exam_counts where the heart's middle is; noise
/// is Rician, a function of seed, voxel and frame alone.
[[nodiscard]] Cine imaged_stack(const Family& family, const DrawnScene& scene,
                                const DrawnStack& stack, VoxelShape shape, StageContext& context);

}  // namespace beatlas::phantom
