#pragma once
/// Exam -> labels and sub-voxel coverage of the heart's structures, by seeded region growing in
/// competition, foreground against background, through all phases.

#include <vector>

#include "pipeline/core/exam.h"
#include "pipeline/core/shapes.h"
#include "pipeline/core/stage_context.h"
#include "pipeline/segment/options.h"

namespace beatlas::prior {
struct PriorCycle;
}

namespace beatlas::segment {

/// Without a prior that holds a heart, seeds or known labels have to tell where the heart is (see
/// seed_ground.h); beside one they win over it.
/// @param known labels to grow the other phases from, which hold in their own, see known_ground.h
/// @param prior of this exam's stack, what its voxels are likely to be; null: nothing was learned
/// @throws Error{InvalidInput} if no heart is found or nothing tells where it is, if there is one
/// phase alone, as check_seeds
[[nodiscard]] Segmentation segment_exam(const Exam& exam, const std::vector<Seed>& seeds,
                                        const SegmentOptions& options, StageContext& context,
                                        const KnownLabels& known = {},
                                        const prior::PriorCycle* prior = nullptr);

}  // namespace beatlas::segment
