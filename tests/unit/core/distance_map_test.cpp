#include "pipeline/core/distance_map.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/made_images.h"

namespace beatlas {
namespace {

/// By trying every voxel of the mask.
std::vector<float> brute_force(const Grid& grid, const std::vector<std::uint8_t>& mask,
                               bool across_slices) {
  const Vec3 spacing = grid.spacing_mm();
  std::vector<float> out(grid.count(), kNoDistance);
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        double best = kNoDistance;
        for (int c = 0; c < grid.size[2]; ++c) {
          if (!across_slices && c != k) continue;
          for (int b = 0; b < grid.size[1]; ++b) {
            for (int a = 0; a < grid.size[0]; ++a) {
              if (mask[grid.offset(a, b, c)] == 0) continue;
              best = std::min(best, Vec3(a - i, b - j, c - k).cwiseProduct(spacing).norm());
            }
          }
        }
        out[grid.offset(i, j, k)] = static_cast<float>(best);
      }
    }
  }
  return out;
}

// Squares are kept in single precision between the axes: 1e-6 of a distance of 100 mm.
constexpr double kRounding = 1e-4;

TEST(DistanceMap, IsThatOfBruteForceOnRandomMasks) {
  std::mt19937 random(3);
  const std::vector<Vec3> spacings{{1, 1, 1}, {1.4, 0.7, 10}, {0.31, 2.7, 1.1}, {1, 1, 20}};
  for (std::size_t n = 0; n < 24; ++n) {
    const Grid grid = made::straight_grid({11, 13, 7}, spacings[n % spacings.size()]);
    const unsigned rarity = n < 8 ? 2 : n < 16 ? 30 : 400;
    std::vector<std::uint8_t> mask(grid.count());
    for (auto& value : mask) value = random() % rarity == 0 ? 255 : 0;
    for (bool across : {true, false}) {
      const std::vector<float> expected = brute_force(grid, mask, across);
      const std::vector<float> found = distance_map(grid, mask, across);
      for (std::size_t v = 0; v < mask.size(); ++v) {
        ASSERT_NEAR(found[v], expected[v], kRounding) << "mask " << n << " voxel " << v;
      }
    }
  }
}

TEST(DistanceMap, NearAMaskIsTheSameWithinReach) {
  std::mt19937 random(5);
  constexpr double kReachMm = 4;
  int beyond = 0;
  for (int n = 0; n < 12; ++n) {
    const Grid grid = made::straight_grid({19, 17, 9}, {1.1, 0.9, n % 2 == 0 ? 2.5 : 10});
    std::vector<std::uint8_t> mask(grid.count());
    // A lump of voxels, or none at all.
    const int i = static_cast<int>(random() % 19);
    const int j = static_cast<int>(random() % 17);
    const int k = static_cast<int>(random() % 9);
    for (int voxel = 0; voxel < n; ++voxel) {
      const auto near = [&](int at, int size) {
        return std::clamp(at + static_cast<int>(random() % 5) - 2, 0, size - 1);
      };
      mask[grid.offset(near(i, 19), near(j, 17), near(k, 9))] = 1;
    }
    for (const bool across : {true, false}) {
      const std::vector<float> whole = distance_map(grid, mask, across);
      const std::vector<float> near = distance_near(grid, mask, across, kReachMm);
      for (std::size_t v = 0; v < mask.size(); ++v) {
        EXPECT_EQ(near[v] < kNoDistance, whole[v] < kNoDistance) << n << " " << v;
        if (whole[v] <= kReachMm) {
          ASSERT_NEAR(near[v], whole[v], kRounding) << n << " " << v;
        } else {
          ASSERT_GT(near[v], kReachMm) << n << " " << v;
          ++beyond;
        }
      }
    }
  }
  EXPECT_GT(beyond, 0);
}

TEST(DistanceMap, DepthWithinAMaskIsTheDistanceToWhatIsNotInIt) {
  const Grid grid = made::straight_grid({24, 20, 12}, {1, 1.3, 2});
  std::vector<std::uint8_t> mask(grid.count(), 0);
  std::vector<std::uint8_t> others(grid.count(), 1);
  for (int k = 0; k < 7; ++k) {  // at the grid's border on one side
    for (int j = 3; j < 15; ++j) {
      for (int i = 4; i < 20; ++i) {
        if ((i - 12) * (i - 12) + (j - 9) * (j - 9) + k * k > 40) continue;
        mask[grid.offset(i, j, k)] = 255;
        others[grid.offset(i, j, k)] = 0;
      }
    }
  }
  const std::vector<float> expected = distance_map(grid, others, true);
  const std::vector<float> found = depth_within(grid, mask, true);
  for (std::size_t v = 0; v < mask.size(); ++v) ASSERT_NEAR(found[v], expected[v], kRounding) << v;
}

TEST(DistanceMap, OfAnEmptyMaskSaysThatThereIsNone) {
  const Grid grid = made::straight_grid({5, 4, 3}, {1, 2, 3});
  const std::vector<std::uint8_t> empty(grid.count(), 0);
  for (bool across : {true, false}) {
    for (float d : distance_map(grid, empty, across)) EXPECT_EQ(d, kNoDistance);
  }
}

TEST(DistanceMap, LeavesEmptySlicesAloneWhenSlicesStandAlone) {
  const Grid grid = made::straight_grid({6, 6, 2}, {1, 1, 1});
  std::vector<std::uint8_t> mask(grid.count(), 0);
  mask[grid.offset(2, 2, 0)] = 1;
  const std::vector<float> alone = distance_map(grid, mask, false);
  EXPECT_EQ(alone[grid.offset(2, 2, 1)], kNoDistance);
  EXPECT_NEAR(alone[grid.offset(5, 2, 0)], 3, kRounding);
  EXPECT_NEAR(distance_map(grid, mask, true)[grid.offset(2, 2, 1)], 1, kRounding);
}

TEST(DistanceMap, OfASingleVoxelImageIsZero) {
  const Grid grid = made::straight_grid({1, 1, 1}, {1, 1, 1});
  EXPECT_EQ(distance_map(grid, {1}, true), std::vector<float>{0});
}

}  // namespace
}  // namespace beatlas
