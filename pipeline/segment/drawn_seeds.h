#pragma once
/// A technician's seeds in the competition: what they mark, and what they replace.

#include <string>
#include <vector>

#include "pipeline/core/box.h"
#include "pipeline/segment/competition.h"
#include "pipeline/segment/options.h"
#include "pipeline/tissue/levels.h"

namespace beatlas::segment {

/// The voxels that a seed marks, ascending, each once. Empty if it misses the grid.
[[nodiscard]] std::vector<std::size_t> voxels_of(const Grid& grid, const Seed& seed);

/// "seed 3, lv_blood at (12, -4, 30) mm LPS, phase 2," for a message; counted from 1. What was
/// painted has no number.
[[nodiscard]] std::string seed_told(const std::vector<Seed>& seeds, std::size_t at);

/// The heart's box made to hold a technician's seeds of the heart, with a margin; seeds of
/// background that do not reach it are taken out, for beyond the box all is background.
/// @param grid of the whole stack  @pre check_seeds
[[nodiscard]] Box box_with_seeds(const Grid& grid, const Box& box, std::vector<Seed>& seeds);

/// Draws a technician's seeds: in their slices and phases they replace the automatic ones of their
/// label, elsewhere those stay. Those of background, which is many things, add to the automatic
/// ones. A seed marks the voxels whose centres lie in its ball, at least the voxel it lies in; a
/// stroke those within its radius of its line, at least those that the line crosses, so it has no
/// gaps.
/// @param grid of the images or a part of it  @throws Error{InvalidInput} as check_seeds does, but
/// that only a part of a stroke need be in the grid
void draw_seeds(const Grid& grid, const std::vector<Seed>& seeds, LabelImages& images);

/// Parts the levels of blood and muscle that were marked.
/// @throws Error{InvalidInput} if muscle was marked on what is as bright as blood
void part_marked(tissue::TissueLevels& levels);

/// Seeds that are likely a slip, a sentence each as seed_told begins it: where
/// the image is as dark as muscle or lung under a seed of blood, as bright as blood or as dark as
/// lung under one of muscle, as dark as lung under one of the rest. At most five, and how many
/// more. They are followed all the same.
/// @param levels without blood above muscle: images tell nothing
[[nodiscard]] std::vector<std::string> doubtful_seeds(const ImageCycle<float>& images,
                                                      const std::vector<Seed>& seeds,
                                                      const tissue::TissueLevels& levels);

/// @throws Error{InvalidInput} if a seed or a place of a stroke lies outside the images, has no
/// known label or phase, or a radius that is not within 0..50 mm.
void check_seeds(const std::vector<Seed>& seeds, const Grid& grid, int phases);

}  // namespace beatlas::segment
