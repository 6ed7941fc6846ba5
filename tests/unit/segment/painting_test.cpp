#include "pipeline/segment/painting.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "pipeline/segment/drawn_seeds.h"
#include "runtime/base/error.h"
#include "tests/made_images.h"

namespace beatlas::segment {
namespace {

std::vector<std::uint8_t> blank(const Grid& grid) {
  return std::vector<std::uint8_t>(grid.count(), kNotPainted);
}

/// What the seeds of a painting mark when they are drawn.
std::vector<std::uint8_t> drawn(const Grid& painted_grid, const std::vector<std::uint8_t>& painted,
                                const Grid& grid) {
  LabelImages images(1, std::vector<std::uint8_t>(grid.count(), kUnlabelled));
  draw_seeds(grid, seeds_of_painting(painted_grid, painted, 0, grid), images);
  return images[0];
}

TEST(Painting, OnTheGridOfTheImagesMarksJustWhatIsPainted) {
  const Grid grid = made::oblique_grid({40, 30, 7}, {1.3, 1.7, 9}, {20, -40, 11});
  std::vector<std::uint8_t> painted = blank(grid);
  for (int k = 2; k <= 3; ++k) {
    for (int j = 0; j < 30; ++j) {
      for (int i = 0; i < 40; ++i) {
        const double r = std::hypot(i - 18, j - 14);
        if (r < 6) painted[grid.offset(i, j, k)] = kLabelLvBlood;
        if (r > 8 && r < 9.5) painted[grid.offset(i, j, k)] = kLabelLvMyocardium;
        if (r > 13) painted[grid.offset(i, j, k)] = kLabelBackground;  // up to the edges
      }
    }
  }
  static_assert(kNotPainted == kUnlabelled);
  EXPECT_EQ(drawn(grid, painted, grid), painted);
  const std::vector<Seed> seeds = seeds_of_painting(grid, painted, -1, grid);
  const auto voxels = grid.count() - static_cast<std::size_t>(
                                         std::count(painted.begin(), painted.end(), kNotPainted));
  EXPECT_LT(seeds.size(), voxels / 5) << "runs, not voxels";
  for (const Seed& seed : seeds) EXPECT_EQ(seed.phase, -1);
}

TEST(Painting, CoarserThanTheImagesLeavesNoGaps) {
  const Grid grid = made::oblique_grid({48, 48, 20}, {1, 1, 2}, {5, 6, 7});
  Grid coarse = grid;
  coarse.size = {12, 12, 5};
  coarse.mm_from_index.linear() = grid.mm_from_index.linear() * 4;
  coarse.mm_from_index.translation() = grid.mm(1.5, 1.5, 1.5);
  std::vector<std::uint8_t> painted = blank(coarse);
  painted[coarse.offset(5, 6, 2)] = kLabelRvBlood;
  const std::vector<std::uint8_t> marks = drawn(coarse, painted, grid);
  for (int k = 0; k < 20; ++k) {
    for (int j = 0; j < 48; ++j) {
      for (int i = 0; i < 48; ++i) {
        const bool inside = i / 4 == 5 && j / 4 == 6 && k / 4 == 2;
        ASSERT_EQ(marks[grid.offset(i, j, k)], inside ? std::uint8_t{kLabelRvBlood} : kUnlabelled)
            << i << " " << j << " " << k;
      }
    }
  }
}

TEST(Painting, FinerThanTheImagesMarksEveryVoxelItTouches) {
  const Grid thick = made::straight_grid({24, 24, 4}, {2, 2, 10});
  const Grid fine = made::straight_grid({48, 48, 40}, {1, 1, 1});
  std::vector<std::uint8_t> painted = blank(fine);
  // A thin line far from the centres of the thick slices.
  for (int i = 4; i < 30; ++i) painted[fine.offset(i, 15, 13)] = kLabelLvBlood;
  const std::vector<std::uint8_t> marks = drawn(fine, painted, thick);
  for (int i = 4; i < 30; ++i) {
    const auto at = static_cast<int>(std::lround(i / 2.0));
    EXPECT_EQ(marks[thick.offset(at, 8, 1)], kLabelLvBlood) << i;
  }
  const auto marked = std::count(marks.begin(), marks.end(), kLabelLvBlood);
  EXPECT_LE(marked, 15);
}

TEST(Painting, BesideTheImagesGivesNoSeed) {
  const Grid grid = made::straight_grid({20, 20, 5}, {1, 1, 5});
  Grid away = grid;
  away.mm_from_index.translation() = Vec3(500, 0, 0);
  std::vector<std::uint8_t> painted = blank(away);
  painted[away.offset(3, 3, 3)] = kLabelLvBlood;
  EXPECT_TRUE(seeds_of_painting(away, painted, 0, grid).empty());
  EXPECT_TRUE(seeds_of_painting(grid, blank(grid), 0, grid).empty());
}

TEST(LabelsOnGrid, AreThoseOfThePlaceWhateverTheOrderOfAxes) {
  const Grid grid = made::oblique_grid({30, 26, 12}, {1.5, 1.5, 4}, {-8, 30, 2});
  // The same voxels with i and k turned about and two axes swapped.
  Grid turned;
  turned.size = {26, 30, 12};
  Eigen::Matrix3d swap;
  swap << 0, -1, 0, 1, 0, 0, 0, 0, -1;
  turned.mm_from_index.linear() = grid.mm_from_index.linear() * swap;
  turned.mm_from_index.translation() = grid.mm(29, 0, 11);
  LabelCycle given{turned, {std::vector<std::uint8_t>(turned.count(), 0)}};
  const auto label_of = [](int i, int j, int k) {
    return static_cast<std::uint8_t>((i * 7 + j * 3 + k) % 5);
  };
  for (int k = 0; k < 12; ++k) {
    for (int j = 0; j < 30; ++j) {
      for (int i = 0; i < 26; ++i) {
        given.phases[0][turned.offset(i, j, k)] = label_of(29 - j, i, 11 - k);
      }
    }
  }
  const LabelCycle out = labels_on_grid(given, grid);
  ASSERT_TRUE(out.grid == grid);
  for (int k = 0; k < 12; ++k) {
    for (int j = 0; j < 26; ++j) {
      for (int i = 0; i < 30; ++i) {
        ASSERT_EQ(out.phases[0][grid.offset(i, j, k)], label_of(i, j, k));
      }
    }
  }
}

TEST(LabelsOnGrid, DrawnOnShiftedSlicesAreMovedBack) {
  const Grid grid = made::oblique_grid({20, 24, 3}, {1.5, 2, 8}, {20, -40, 11});
  LabelCycle given{grid, {std::vector<std::uint8_t>(grid.count(), 0)}};
  // Slice 1 shows all of it 3 mm farther along i and 4 mm less far along j.
  for (int k = 0; k < 3; ++k)
    given.phases[0][grid.offset(k == 1 ? 12 : 10, k == 1 ? 9 : 11, k)] = 3;
  const LabelCycle out = labels_on_grid(given, grid, {Vec2::Zero(), Vec2(3, -4), Vec2::Zero()});
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(out.phases[0][grid.offset(10, 11, k)], 3) << k;
  }
  EXPECT_EQ(std::count(out.phases[0].begin(), out.phases[0].end(), 3), 3);
  EXPECT_THROW((void)labels_on_grid(given, grid, {Vec2::Zero()}), Error);
}

}  // namespace
}  // namespace beatlas::segment
