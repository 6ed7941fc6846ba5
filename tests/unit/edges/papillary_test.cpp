/// What counts as a papillary muscle in a slice.
#include "pipeline/edges/papillary.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "tests/made_images.h"

namespace beatlas::edges {
namespace {

TEST(Papillary, ADarkRimIsNoMuscleAndASpeckIsNoise) {
  const Grid grid = made::straight_grid({40, 40, 1}, {1, 1, 8});
  ImageCycle<float> images = made::constant_images(grid, 1, 1000);
  ImageCycle<std::uint8_t> labels{grid, {std::vector<std::uint8_t>(grid.count(), kLabelLvBlood)}};
  const auto darken = [&](int i0, int i1, int j0, int j1) {
    for (int j = j0; j < j1; ++j) {
      for (int i = i0; i < i1; ++i) images.phases[0][grid.offset(i, j, 0)] = 300;
    }
  };
  darken(0, 2, 0, 40);     // a rim
  darken(30, 31, 30, 31);  // a speck
  darken(15, 24, 15, 24);  // a muscle
  tissue::TissueLevels levels;
  levels.blood = 1000;
  levels.muscle = 300;
  levels.threshold = 650;
  papillary_muscles_to_wall(images, levels, labels);
  EXPECT_EQ(labels.phases[0][grid.offset(0, 20, 0)], kLabelLvBlood);
  EXPECT_EQ(labels.phases[0][grid.offset(30, 30, 0)], kLabelLvBlood);
  EXPECT_EQ(labels.phases[0][grid.offset(19, 19, 0)], kLabelLvMyocardium);
  const auto count = std::count(labels.phases[0].begin(), labels.phases[0].end(),
                                std::uint8_t{kLabelLvMyocardium});
  EXPECT_NEAR(static_cast<double>(count), 81, 16) << "its corners are rounded off";
}

}  // namespace
}  // namespace beatlas::edges
