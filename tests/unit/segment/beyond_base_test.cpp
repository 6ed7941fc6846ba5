/// Boxes beside two ventricles, named as an atrium or the aorta.
#include "pipeline/segment/beyond_base.h"

#include <gtest/gtest.h>

#include "runtime/atlas/structures.h"
#include "tests/made_images.h"

namespace beatlas::segment {
namespace {

/// An LV in columns 0 to 9 and an RV in columns 10 to 19 of slices 0 to 4, in four phases.
ImageCycle<std::uint8_t> ventricles() {
  const Grid grid = made::straight_grid({20, 10, 10}, {2, 2, 3});
  ImageCycle<std::uint8_t> out{grid, {}};
  out.phases.assign(4, std::vector<std::uint8_t>(grid.count(), kLabelBackground));
  for (std::vector<std::uint8_t>& phase : out.phases) {
    for (std::size_t v = 0; v < grid.offset(0, 0, 5); ++v) {
      phase[v] = v % 20 < 10 ? kLabelLvBlood : kLabelRvBlood;
    }
  }
  return out;
}

void put(ImageCycle<std::uint8_t>& labels, std::size_t phase, std::uint8_t label, int first,
         int end) {
  for (int k = 5; k < 8; ++k) {
    for (int j = 0; j < 10; ++j) {
      for (int i = first; i < end; ++i) labels.phases[phase][labels.grid.offset(i, j, k)] = label;
    }
  }
}

TEST(BeyondBase, WhatOpensIntoItsOwnVentricleThroughTheBeatStays) {
  ImageCycle<std::uint8_t> labels = ventricles();
  for (std::size_t p = 0; p < 4; ++p) {
    put(labels, p, kLabelLaBlood, 1, 6);
    put(labels, p, kLabelAorta, 7, 10);
    put(labels, p, kLabelRaBlood, 12, 18);
  }
  const ImageCycle<std::uint8_t> before = labels;
  EXPECT_TRUE(drop_doubtful_beyond_base({}, labels).empty());
  EXPECT_EQ(labels.phases, before.phases);
}

TEST(BeyondBase, WhatThePriorDoubtsInOnePhaseIsSaidAndRestOfTheHeart) {
  for (const double agreed : {700.0, 600.0}) {
    ImageCycle<std::uint8_t> labels = ventricles();
    for (std::size_t p = 0; p < 4; ++p) put(labels, p, kLabelLaBlood, 1, 6);
    Belief belief;
    belief[Structure::LaBlood].assign(4, {{500, 500, 490}, {500, 500, 490}});
    belief[Structure::LaBlood][2] = {{1000, 500, 400}, {0, 500, agreed - 400}};
    const std::vector<std::string> said = drop_doubtful_beyond_base(belief, labels);
    EXPECT_EQ(said.empty(), agreed > 2.0 / 3 * 1000) << agreed;
    const auto& phase = labels.phases[0];
    EXPECT_EQ(std::count(phase.begin(), phase.end(), kLabelLaBlood), said.empty() ? 150 : 0);
  }
}

TEST(BeyondBase, WhatOpensIntoTheWrongVentricleIsSaidAndRestOfTheHeart) {
  ImageCycle<std::uint8_t> labels = ventricles();
  for (std::size_t p = 0; p < 4; ++p) put(labels, p, kLabelAorta, 12, 18);
  const std::vector<std::string> said = drop_doubtful_beyond_base({}, labels);
  ASSERT_EQ(said.size(), 1U);
  EXPECT_NE(said[0].find("aorta opens into the right ventricle"), std::string::npos) << said[0];
  for (const auto& phase : labels.phases) {
    EXPECT_EQ(std::count(phase.begin(), phase.end(), kLabelAorta), 0);
    EXPECT_EQ(std::count(phase.begin(), phase.end(), kLabelRestOfHeart), 180);
  }
}

TEST(BeyondBase, WhatComesAndGoesOrJumpsIsSaidAndRestOfTheHeart) {
  for (const bool jumps : {false, true}) {
    ImageCycle<std::uint8_t> labels = ventricles();
    for (std::size_t p = 0; p < 4; ++p) {
      if (p != 2) put(labels, p, kLabelLaBlood, 0, 5);
      if (p == 2 && jumps) put(labels, p, kLabelLaBlood, 5, 10);
    }
    const std::vector<std::string> said = drop_doubtful_beyond_base({}, labels);
    ASSERT_EQ(said.size(), 1U);
    EXPECT_NE(said[0].find("in a part of the beat alone"), std::string::npos) << said[0];
  }
}

TEST(BeyondBase, AnAtriumOfTwoPhasesMayEmptyByMoreThanHalf) {
  ImageCycle<std::uint8_t> labels = ventricles();
  labels.phases.resize(2);
  put(labels, 0, kLabelLaBlood, 0, 3);
  put(labels, 1, kLabelLaBlood, 2, 9);
  EXPECT_TRUE(drop_doubtful_beyond_base({}, labels).empty()) << "a fifth of both is shared";
}

}  // namespace
}  // namespace beatlas::segment
