#pragma once
/// Seeds and travel costs of the competition, from what find_chambers saw.

#include <cstdint>
#include <vector>

#include "pipeline/core/slices.h"
#include "pipeline/segment/chambers.h"
#include "pipeline/segment/competition.h"
#include "pipeline/segment/segment.h"

namespace beatlas::segment {

/// What a voxel does through the cycle; index of TravelCost's classes.
enum VoxelClass : std::uint8_t { kStill, kStirring, kMoving };

using LabelImages = std::vector<std::vector<std::uint8_t>>;  ///< [phase][voxel]

/// Classes by swing; the same in every phase.
[[nodiscard]] std::vector<std::uint8_t> classify_motion(const TemporalStats& stats);

/// What a millimetre costs each label. Blood: bright; muscle: between dark and blood; background:
/// what is dark, brighter than blood, or still.
[[nodiscard]] TravelCost travel_cost(const TissueLevels& levels);

/// Seeds of every label from the chambers found.
[[nodiscard]] LabelImages automatic_seeds(const ImageCycle<float>& images,
                                          const TemporalStats& stats, const Chambers& chambers);

}  // namespace beatlas::segment
