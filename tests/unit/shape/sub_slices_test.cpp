#include "pipeline/shape/sub_slices.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/unit/shape/made_shapes.h"

namespace beatlas::shape {
namespace {

// Against the share of a lattice of points, for planes of every kind of direction.
TEST(SubSlices, OfABallAreNearlyItsOwnAndKeepItsVolume) {
  const Vec3 middle(3, -7, 11);
  const Grid grid = made::oblique_grid({60, 60, 20}, {1, 1, 3}, middle);
  const std::vector<float> coverage = made::ball_coverage(grid, middle, 22);
  ASSERT_EQ(parts_of_slices(grid), 3);
  const SubSlices thin = split_slices(grid, coverage, 3);
  ASSERT_EQ(thin.grid.size, (Index3{60, 60, 60}));
  EXPECT_LT((thin.grid.mm(10, 20, 31) - grid.mm(10, 20, 10)).norm(), 1e-9);
  const std::vector<float> truth = made::ball_coverage(thin.grid, middle, 22);
  double sum = 0;
  double blended = 0;
  for (int k = 0; k < 60; ++k) {
    for (int j = 0; j < 60; ++j) {
      for (int i = 0; i < 60; ++i) {
        const double exact = static_cast<double>(truth[thin.grid.offset(i, j, k)]);
        sum += std::pow(static_cast<double>(thin.coverage[thin.grid.offset(i, j, k)]) - exact, 2);
        blended += std::pow(static_cast<double>(coverage[grid.offset(i, j, k / 3)]) - exact, 2);
      }
    }
  }
  EXPECT_LT(std::sqrt(sum), 0.1 * std::sqrt(blended));
  for (std::size_t v = 0; v < coverage.size(); v += 7) {
    const auto i = static_cast<int>(v % 60);
    const auto j = static_cast<int>(v / 60 % 60);
    const auto k = static_cast<int>(v / 3600);
    double mean = 0;
    for (int part = 0; part < 3; ++part) {
      mean += static_cast<double>(thin.coverage[thin.grid.offset(i, j, 3 * k + part)]) / 3;
    }
    ASSERT_NEAR(mean, static_cast<double>(coverage[v]), 1e-5);
  }
}

TEST(SubSlices, AreTheSlicesWhereTheseAreThin) {
  EXPECT_EQ(parts_of_slices(made::straight_grid({8, 8, 8}, {1, 1, 1})), 1);
  EXPECT_EQ(parts_of_slices(made::straight_grid({8, 8, 8}, {0.5, 0.5, 1})), 1);
  EXPECT_EQ(parts_of_slices(made::straight_grid({8, 8, 8}, {2, 2, 4})), 3);
  const Grid grid = made::straight_grid({30, 30, 30}, {1, 1, 1});
  const std::vector<float> coverage = made::ball_coverage(grid, {15, 15, 15}, 9);
  const SubSlices same = split_slices(grid, coverage, 1);
  for (std::size_t v = 0; v < coverage.size(); ++v) {
    ASSERT_NEAR(same.coverage[v], coverage[v], 1e-5F);
  }
}

}  // namespace
}  // namespace beatlas::shape
