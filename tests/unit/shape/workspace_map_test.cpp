#include <gtest/gtest.h>

#include "pipeline/shape/workspace.h"
#include "tests/unit/shape/made_shapes.h"

namespace beatlas::shape {
namespace {

const Vec3 kCentre(128, 128, 96);

/// A ball whose centre wanders from phase to phase.
CoverageCycle wandering_ball(const Grid& grid, const std::vector<Vec3>& centres) {
  CoverageCycle coverage;
  coverage.grid = grid;
  for (const Vec3& centre : centres) {
    coverage.phases[Structure::Heart].push_back(made::ball_coverage(grid, centre, 12));
  }
  return coverage;
}

void expect_rigid(const Affine& map) {
  const Eigen::Matrix3d r = map.linear();
  EXPECT_LT((r * r.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  EXPECT_NEAR(r.determinant(), 1, 1e-12);
}

TEST(WorkspaceMap, TakesThePublishedGridVoxelToVoxelWhereverItLies) {
  for (const Grid& grid : {made::straight_grid({256, 256, 64}, {1, 1, 3}),
                           made::oblique_grid({256, 256, 64}, {1, 1, 3}, {31, -55, 120})}) {
    const Affine map = workspace_from_lps(grid, {});
    expect_rigid(map);
    for (const Index3& at : {Index3{0, 0, 0}, Index3{255, 255, 63}, Index3{17, 130, 40}}) {
      const auto [i, j, k] = at;
      // Voxel (i, j, k) covers [i, i+1] x [j, j+1] x [3k, 3k+3]: both corners.
      EXPECT_LT((map * grid.mm(i - 0.5, j - 0.5, k - 0.5) - Vec3(i, j, 3 * k)).norm(), 1e-9);
      EXPECT_LT((map * grid.mm(i + 0.5, j + 0.5, k + 0.5) - Vec3(i + 1, j + 1, 3 * k + 3)).norm(),
                1e-9);
    }
  }
}

TEST(WorkspaceMap, PutsTheTimeMeanCentroidOfAnyOtherGridAtTheCentre) {
  const Vec3 middle(20, -40, 60);
  const std::vector<Vec3> centres{middle + Vec3(-4, 1, 2), middle + Vec3(3, 2, -1),
                                  middle + Vec3(0, -4, 4)};
  const Vec3 mean = (centres[0] + centres[1] + centres[2]) / 3;
  for (const Vec3& spacing : {Vec3(1, 1, 3), Vec3(1.4, 1.4, 4), Vec3(2, 1.5, 3)}) {
    const Grid grid = made::oblique_grid({44, 44, 24}, spacing, middle);
    const Affine map = workspace_from_lps(grid, wandering_ball(grid, centres));
    expect_rigid(map);
    // Coverage of a ball has the ball's own centroid, to what flat pieces of surface leave.
    EXPECT_LT((map * mean - kCentre).norm(), 0.02) << spacing.transpose();
    // Axes along row, column and row x column.
    EXPECT_LT(
        (map.linear() * grid.mm_from_index.linear().col(0).normalized() - Vec3::UnitX()).norm(),
        1e-12);
    EXPECT_LT(
        (map.linear() * grid.mm_from_index.linear().col(1).normalized() - Vec3::UnitY()).norm(),
        1e-12);
  }
}

TEST(WorkspaceMap, WeighsPhasesByTheirVolume) {
  const Grid grid = made::straight_grid({60, 60, 30}, {1, 1, 2});
  CoverageCycle coverage;
  coverage.grid = grid;
  coverage.phases[Structure::Heart] = {made::ball_coverage(grid, {25, 30, 28}, 15),
                                       made::ball_coverage(grid, {35, 30, 28}, 10)};
  const Affine map = workspace_from_lps(grid, coverage);
  const double x = (25 * std::pow(15, 3) + 35 * std::pow(10, 3)) / (std::pow(15, 3) + 1000);
  EXPECT_LT((map * Vec3(x, 30, 28) - kCentre).norm(), 0.02);
}

TEST(WorkspaceMap, IsNoMirrorForALeftHandedGrid) {
  // Even one of the published matrix and spacing: no rigid map takes it voxel to voxel.
  for (const Index3& size : {Index3{256, 256, 64}, Index3{40, 40, 20}}) {
    Grid grid = made::oblique_grid(size, {1, 1, 3}, {5, 6, 7});
    grid.mm_from_index.linear().col(2) *= -1;
    ASSERT_LT(grid.mm_from_index.linear().determinant(), 0);
    const Vec3 heart = grid.mm(20, 19, 10);
    const Index3 first{4, 4, 4};
    CoverageCycle coverage = wandering_ball(grid.part(first, {32, 32, 12}), {heart});
    coverage.first = first;
    const Affine map = workspace_from_lps(grid, coverage);
    expect_rigid(map);
    EXPECT_LT((map * heart - kCentre).norm(), 0.02);
    EXPECT_LT(
        (map.linear() * grid.mm_from_index.linear().col(2).normalized() + Vec3::UnitZ()).norm(),
        1e-12);
  }
}

TEST(WorkspaceMap, StaysRigidForAxesThatAreSlightlyAskew) {
  Grid grid = made::oblique_grid({40, 40, 20}, {1.2, 1.2, 4}, {5, 6, 7});
  grid.mm_from_index.linear().col(1) += 2e-3 * grid.mm_from_index.linear().col(0);
  const Affine map = workspace_from_lps(grid, wandering_ball(grid, {grid.mm(20, 20, 10)}));
  expect_rigid(map);
  EXPECT_LT((map * grid.mm(20, 20, 10) - kCentre).norm(), 0.05);
}

TEST(WorkspaceMap, RefusesASegmentationWithoutAHeart) {
  const Grid grid = made::straight_grid({20, 20, 10}, {1, 1, 1});
  EXPECT_THROW((void)workspace_from_lps(grid, {}), Error);
  CoverageCycle empty;
  empty.grid = grid;
  empty.phases[Structure::Heart] = {std::vector<float>(grid.count(), 0)};
  EXPECT_THROW((void)workspace_from_lps(grid, empty), Error);
}

TEST(Shapes, AreNoFinerThanTheirSlicesCanTell) {
  EXPECT_EQ(lattice_edge_mm(3, {}, {}), 1);
  EXPECT_DOUBLE_EQ(lattice_edge_mm(8, 10, {}), 1.35);
  EXPECT_EQ(lattice_edge_mm(8, 10, {}), lattice_edge_mm(7.99999, 10, {}));
  EXPECT_EQ(lattice_edge_mm(17.7, {}, {}), 1.5);
  EXPECT_DOUBLE_EQ(lattice_edge_mm(17.7, 5.4, {}), 1.2);
  EXPECT_EQ(lattice_edge_mm(17.7, 3, {}), 1);
  RegisterOptions told;
  told.shape_mm = 0.8;
  EXPECT_EQ(lattice_edge_mm(17.7, 3, told), 0.8);
}

}  // namespace
}  // namespace beatlas::shape
