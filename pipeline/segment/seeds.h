#pragma once
/// Seeds and travel costs of the competition, from what find_chambers saw or a technician drew.

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

/// The heart's box made to hold a technician's seeds of the heart, with a margin; seeds of
/// background that do not reach it are taken out, for beyond the box all is background.
/// @param grid of the whole stack  @pre check_seeds
[[nodiscard]] Box box_with_seeds(const Grid& grid, const Box& box, std::vector<Seed>& seeds);

/// Draws a technician's seeds: in their slices and phases they replace the automatic ones of their
/// label, elsewhere those stay.
/// A seed marks the voxels whose centres lie in its ball, at least the voxel it lies in.
/// @throws Error{InvalidInput} as check_seeds does
void draw_seeds(const Grid& grid, const std::vector<Seed>& seeds, LabelImages& images);

/// Slices with a drawn seed of LV blood belong to the LV, see adopt_lv_slice.
void adopt_seeds(const ImageCycle<float>& images, const std::vector<Seed>& seeds,
                 Chambers& chambers);

}  // namespace beatlas::segment
