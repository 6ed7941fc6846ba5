#include "pipeline/ingest/slice_axis.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

namespace beatlas::ingest {
namespace {

/// Axis n of the new grid is axis order[n] of the old one, turned round where flip[n].
Grid reordered(const Grid& grid, const std::array<int, 3>& order, int flips) {
  Grid out = grid;
  for (std::size_t n = 0; n < 3; ++n) {
    const auto from = static_cast<std::size_t>(order[n]);
    out.size[n] = grid.size[from];
    Vec3 along = grid.mm_from_index.linear().col(order[n]);
    if ((flips >> n & 1) != 0) {
      out.mm_from_index.translation() += along * (grid.size[from] - 1);
      along = -along;
    }
    out.mm_from_index.linear().col(static_cast<Eigen::Index>(n)) = along;
  }
  return out;
}

Grid grid_of(const Index3& size, const Vec3& spacing_mm) {
  Grid grid{size, Affine::Identity()};
  grid.mm_from_index.linear() =
      (Eigen::AngleAxisd(0.5, Vec3::UnitX()) * Eigen::AngleAxisd(-0.4, Vec3::UnitY()))
          .toRotationMatrix() *
      spacing_mm.asDiagonal();
  grid.mm_from_index.translation() = Vec3(-31, 17, 5);
  return grid;
}

/// Of no symmetry, so that a voxel at another place shows.
float value_at(const Vec3& mm, int phase) {
  return static_cast<float>(mm[0] + 3.1 * mm[1] - 2.3 * mm[2] + 100 * phase);
}

TEST(SliceAxis, IsFoundAndPutLastInEveryOrderAndDirection) {
  const Grid scanned = grid_of({7, 6, 4}, {1.7, 1.9, 10});
  std::array<int, 3> order{0, 1, 2};
  do {
    for (int flips = 0; flips < 8; ++flips) {
      ImageCycle<float> images{reordered(scanned, order, flips), {}};
      const Grid given = images.grid;
      for (int p = 0; p < 2; ++p) {
        images.phases.emplace_back();
        for (int k = 0; k < given.size[2]; ++k) {
          for (int j = 0; j < given.size[1]; ++j) {
            for (int i = 0; i < given.size[0]; ++i) {
              images.phases.back().push_back(value_at(given.mm(i, j, k), p));
            }
          }
        }
      }
      const int axis = slice_axis(given);
      ASSERT_EQ(order.at(static_cast<std::size_t>(axis)), 2);
      put_axis_last(images, axis);
      const Grid& grid = images.grid;
      EXPECT_EQ(grid.size[2], 4);
      EXPECT_NEAR(grid.spacing_mm()[2], 10, 1e-9);
      EXPECT_NEAR(grid.mm_from_index.linear().determinant(),
                  given.mm_from_index.linear().determinant(), 1e-9);
      EXPECT_EQ(slice_axis(grid), 2);
      double worst = 0;
      for (int p = 0; p < 2; ++p) {
        const std::vector<float>& phase = images.phases[static_cast<std::size_t>(p)];
        ASSERT_EQ(phase.size(), grid.count());
        for (int k = 0; k < grid.size[2]; ++k) {
          for (int j = 0; j < grid.size[1]; ++j) {
            for (int i = 0; i < grid.size[0]; ++i) {
              const double off = phase[grid.offset(i, j, k)] - value_at(grid.mm(i, j, k), p);
              worst = std::max(worst, std::abs(off));
            }
          }
        }
      }
      EXPECT_LT(worst, 1e-3);
    }
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST(SliceAxis, ThatNothingTellsIsTheThird) {
  EXPECT_EQ(slice_axis(grid_of({40, 50, 60}, {1, 1, 1})), 2);         // isotropic
  EXPECT_EQ(slice_axis(grid_of({40, 90, 100}, {1.1, 1, 1})), 2);      // hardly apart
  EXPECT_EQ(slice_axis(grid_of({90, 100, 200}, {4, 4, 0.5})), 2);     // the odd one is the finest
  EXPECT_EQ(slice_axis(grid_of({80, 200, 40}, {2.4, 1, 1.6})), 2);    // no two alike
  EXPECT_EQ(slice_axis(grid_of({200, 190, 100}, {4, 1.5, 1.5})), 2);  // coarse, but many
}

}  // namespace
}  // namespace beatlas::ingest
