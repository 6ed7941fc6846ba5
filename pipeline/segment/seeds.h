#pragma once
/// Seeds and travel costs of the competition, from what find_chambers saw.

#include <cstdint>
#include <vector>

#include "pipeline/core/slices.h"
#include "pipeline/segment/chambers.h"
#include "pipeline/segment/competition.h"
#include "pipeline/segment/segment.h"

namespace beatlas::segment {

/// What a voxel does through the cycle. Index of TravelCost's classes, to which come, in a phase in
/// which it lies beyond the plane of the LV's base or of the RV's, kBeyondLv and kBeyondRv.
enum VoxelClass : std::uint8_t { kStill, kStirring, kMoving };
inline constexpr std::uint8_t kBeyondLv = 3;
inline constexpr std::uint8_t kBeyondRv = 6;

using LabelImages = std::vector<std::vector<std::uint8_t>>;  ///< [phase][voxel]

/// Classes by swing; the same in every phase.
[[nodiscard]] std::vector<std::uint8_t> classify_motion(const TemporalStats& stats);

/// Those classes and the base planes of each phase, [phase][voxel].
[[nodiscard]] LabelImages classify(const std::vector<std::uint8_t>& motion,
                                   const Chambers& chambers, std::size_t phases);

/// What a millimetre costs each label. Blood: bright; muscle: between dark and blood; background:
/// what is dark, brighter than blood, or still. Beyond its base plane the LV travels hard, the RV,
/// whose plane is a guess, harder than the atria.
[[nodiscard]] TravelCost travel_cost(const TissueLevels& levels, double noise);

/// Seeds of every label from the chambers found.
[[nodiscard]] LabelImages automatic_seeds(const ImageCycle<float>& images,
                                          const TemporalStats& stats, const Chambers& chambers);

}  // namespace beatlas::segment
