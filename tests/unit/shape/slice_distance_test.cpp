#include "pipeline/shape/slice_distance.h"

#include <gtest/gtest.h>

#include "tests/unit/shape/made_shapes.h"

namespace beatlas::shape {
namespace {

/// Coverage of a disc in every voxel of a slice, by 10 x 10 points a pixel.
std::vector<float> disc_coverage(const Grid& grid, double x, double y, double radius_mm) {
  constexpr int kSteps = 10;
  std::vector<float> out;
  for (int j = 0; j < grid.size[1]; ++j) {
    for (int i = 0; i < grid.size[0]; ++i) {
      int hits = 0;
      for (int n = 0; n < kSteps * kSteps; ++n) {
        const Vec3 at = grid.mm(i + (n % kSteps + 0.5) / kSteps - 0.5,
                                j + (n / kSteps + 0.5) / kSteps - 0.5, 0);
        hits += std::hypot(at[0] - x, at[1] - y) < radius_mm;
      }
      out.push_back(static_cast<float>(hits) / (kSteps * kSteps));
    }
  }
  return out;
}

void expect_disc(const Vec3& spacing) {
  const Grid grid = made::straight_grid(
      {static_cast<int>(84 / spacing[0]), static_cast<int>(84 / spacing[1]), 1}, spacing);
  const double radius = 24;
  const auto slices = slice_distances(grid, disc_coverage(grid, 41.3, 40.2, radius));
  ASSERT_EQ(slices.size(), 1U);
  ASSERT_EQ(slices[0].size(), grid.count());
  double mean = 0;
  int near = 0;
  for (int j = 0; j < grid.size[1]; ++j) {
    for (int i = 0; i < grid.size[0]; ++i) {
      const Vec3 at = grid.mm(i, j, 0);
      const double expected = std::hypot(at[0] - 41.3, at[1] - 40.2) - radius;
      const double error = slices[0][grid.offset(i, j, 0)] - expected;
      // Fine pixels of 0.35 mm: one of them. At the very centre the mean over a pixel of what has a
      // peak there is off by a third of a pixel.
      EXPECT_NEAR(error, 0, expected < -radius + 2 * spacing[1] ? 0.4 * spacing[1] + 0.35 : 0.35)
          << i << " " << j;
      if (std::abs(expected) < 3) {
        mean += error;
        ++near;
      }
    }
  }
  EXPECT_NEAR(mean / near, 0, 0.05);  // no bias at the outline
}

TEST(SliceDistance, OfADiscIsTheRadiusLess) { expect_disc({1.4, 1.4, 10}); }

TEST(SliceDistance, IsInMillimetresForOblongPixels) { expect_disc({1.0, 1.6, 10}); }

TEST(SliceDistance, IsEmptyForASliceWithoutTheStructure) {
  const Grid grid = made::straight_grid({8, 8, 3}, {1, 1, 8});
  std::vector<float> coverage(grid.count(), 0);
  coverage[grid.offset(4, 4, 1)] = 1;
  coverage[grid.offset(4, 4, 2)] = 0.4F;
  const auto slices = slice_distances(grid, coverage);
  EXPECT_TRUE(slices[0].empty());
  EXPECT_EQ(slices[1].size(), 64U);
  EXPECT_TRUE(slices[2].empty());
}

TEST(SliceDistance, IsEmptyForAVoxelHalfCoveredThatNoContourSurrounds) {
  const Grid grid = made::straight_grid({8, 8, 1}, {2, 2, 8});
  std::vector<float> coverage(grid.count(), 0);
  coverage[grid.offset(4, 4, 0)] = 0.51F;
  EXPECT_TRUE(slice_distances(grid, coverage)[0].empty());
  coverage[grid.offset(4, 4, 0)] = 1;
  const auto slices = slice_distances(grid, coverage);
  ASSERT_EQ(slices[0].size(), grid.count());
  for (const float d : slices[0]) EXPECT_LT(std::abs(d), 16);
}

TEST(SliceDistance, OfAFullSliceIsFiniteAndInside) {
  const Grid grid = made::straight_grid({8, 6, 1}, {1, 1, 8});
  const auto slices = slice_distances(grid, std::vector<float>(grid.count(), 1));
  ASSERT_EQ(slices[0].size(), grid.count());
  for (float d : slices[0]) EXPECT_TRUE(std::isfinite(d) && d < -1) << d;
}

}  // namespace
}  // namespace beatlas::shape
