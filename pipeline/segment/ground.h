#pragma once
/// What is known of an exam before anything grows, whether a prior tells it or a person.

#include "pipeline/segment/competition.h"
#include "pipeline/tissue/levels.h"

namespace beatlas::segment {

inline constexpr std::size_t kLabels = VoxelPrices::kLabels;

/// On the grid of the images in which labels are to grow.
struct Ground {
  LabelImages seeds;            ///< where a label is sure, kUnlabelled elsewhere
  VoxelPrices prices;           ///< from how likely labels are there and what they look like
  tissue::TissueLevels levels;  ///< medians of what is sure
};

}  // namespace beatlas::segment
