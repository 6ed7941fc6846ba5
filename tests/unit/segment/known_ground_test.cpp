/// Labels of a person beside a prior, on made grounds.
#include "pipeline/segment/known_ground.h"

#include <gtest/gtest.h>

#include "runtime/atlas/structures.h"
#include "tests/made_images.h"

namespace beatlas::segment::known_ground_tests {
namespace {

/// Six voxels in a row, two phases; the first is known.
struct Made {
  KnownLabels known;
  Ground ground;
  ImageCycle<std::uint8_t> labels;

  Made(std::vector<std::uint8_t> image, std::vector<std::uint8_t> grown) {
    known.labels.grid = made::straight_grid({6, 1, 1}, {1, 1, 1});
    known.labels.phases = {std::move(image)};
    known.phases = {0};
    labels.grid = known.labels.grid;
    labels.phases = {grown, grown};
    ground.seeds = labels.phases;
    ground.prices.phases.assign(2,
                                std::vector<std::uint8_t>(grown.size() * VoxelPrices::kLabels, 40));
  }
};

TEST(KnownGround, WhatAPhaseHasNowhereIsUnknownThere) {
  Made made({0, 0, 3, 3, 255, 0}, {1, 2, 2, 3, 3, 3});
  put_known(made.known, made.labels);
  // RV and wall stay as they grew; cavity that was not drawn is wall.
  EXPECT_EQ(made.labels.phases[0], (std::vector<std::uint8_t>{1, 2, 3, 3, 3, 2}));
  EXPECT_EQ(made.labels.phases[1], (std::vector<std::uint8_t>{1, 2, 2, 3, 3, 3}));
}

TEST(KnownGround, WhatAPhaseHasIsNowhereElse) {
  Made made({0, 2, 3, 2, 0, 0}, {2, 2, 3, 3, 2, 5});
  put_known(made.known, made.labels);
  EXPECT_EQ(made.labels.phases[0], (std::vector<std::uint8_t>{0, 2, 3, 2, 0, 5}));
}

TEST(KnownGround, KnownLabelsAreSeedsAndTheirPlacesElsewhereAreDear) {
  Made made({0, 0, 3, 3, 255, 0}, {1, 2, 2, 3, 3, 3});
  hold_known(made.known, made.ground);
  EXPECT_EQ(made.ground.seeds[0], (std::vector<std::uint8_t>{1, 2, 3, 3, 3, kUnlabelled}));
  const auto price = [&](std::size_t phase, std::size_t voxel, std::size_t label) {
    return made.ground.prices.phases[phase][voxel * VoxelPrices::kLabels + label];
  };
  EXPECT_EQ(price(0, 0, kLabelLvBlood), 255);
  EXPECT_EQ(price(0, 0, kLabelRvBlood), 40);
  EXPECT_EQ(price(0, 2, kLabelLvBlood), VoxelPrices::kUnits);
  EXPECT_EQ(price(0, 4, kLabelLvBlood), 40);
  EXPECT_EQ(price(1, 0, kLabelLvBlood), 40);
}

}  // namespace
}  // namespace beatlas::segment::known_ground_tests
