/// Boxes of voxels, against their meaning voxel by voxel.
#include "pipeline/core/box.h"

#include <array>
#include <random>

#include <gtest/gtest.h>

#include "tests/made_images.h"

namespace beatlas {
namespace {

TEST(Boxes, TheLeastBoxHoldsEveryVoxelAndTouchesOneOnEachSide) {
  const Grid grid = made::straight_grid({9, 7, 5}, {1, 1, 3});
  std::mt19937 random(3);
  for (int round = 0; round < 50; ++round) {
    std::vector<std::vector<std::uint8_t>> phases(2, std::vector<std::uint8_t>(grid.count()));
    std::vector<std::size_t> voxels;
    const auto count = 1 + random() % 4;
    for (std::size_t n = 0; n < count; ++n) {
      voxels.push_back(random() % grid.count());
      phases[n % 2][voxels.back()] = 7;
    }
    const Box box = box_around(grid, phases);
    std::array<bool, 6> touched{};
    for (const std::size_t v : voxels) {
      const Index3 at = index_of(grid, v);
      EXPECT_EQ(grid.offset(at[0], at[1], at[2]), v);
      EXPECT_TRUE(box.contains(at));
      for (std::size_t a = 0; a < 3; ++a) {
        touched[2 * a] = touched[2 * a] || at[a] == box.first[a];
        touched[2 * a + 1] = touched[2 * a + 1] || at[a] == box.first[a] + box.size[a] - 1;
      }
    }
    for (const bool side : touched) EXPECT_TRUE(side);
    const Box same = box_around_voxels(grid, voxels);
    EXPECT_EQ(same.first, box.first);
    EXPECT_EQ(same.size, box.size);
  }
}

TEST(Boxes, NothingHasNoBoxAndMovesNone) {
  const Grid grid = made::straight_grid({9, 7, 5}, {1, 1, 3});
  const Box none = box_around(grid, std::vector<std::uint8_t>(grid.count()));
  EXPECT_TRUE(none.empty());
  EXPECT_TRUE(with_room(grid, none, {2, 2, 2}).empty());
  const Box box{{1, 2, 3}, {2, 2, 1}};
  EXPECT_FALSE(box.contains({3, 2, 3}));
  EXPECT_EQ(widened(grid, box, none).size, box.size);
}

TEST(Boxes, RoomEndsWhereTheGridDoes) {
  const Grid grid = made::straight_grid({9, 7, 5}, {1, 1, 3});
  const Box box = with_room(grid, {{1, 2, 3}, {2, 2, 1}}, {2, 1, 4});
  EXPECT_EQ(box.first, (Index3{0, 1, 0}));
  EXPECT_EQ(box.size, (Index3{5, 4, 5}));
}

TEST(Boxes, ASideThatIsTouchedGetsAMargin) {
  const Grid grid = made::straight_grid({90, 90, 30}, {1, 2, 3});
  const Box box = widened(grid, {{45, 45, 15}, {1, 1, 1}}, {{45, 35, 15}, {9, 11, 10}});
  EXPECT_EQ(box.first, (Index3{25, 25, 8}));
  EXPECT_EQ(box.size, (Index3{49, 31, 22}));
}

TEST(Boxes, OnlySidesThatMoveGetAMargin) {
  const Grid grid = made::straight_grid({90, 90, 30}, {1, 2, 3});
  const Box box = widened(grid, {{30, 30, 10}, {20, 20, 5}}, {{28, 35, 12}, {10, 17, 20}});
  EXPECT_EQ(box.first, (Index3{8, 30, 10}));
  EXPECT_EQ(box.size, (Index3{42, 32, 20}));
}

TEST(Crop, KeepsEveryVoxelWhereItIsInThePatient) {
  const Grid grid = made::oblique_grid({9, 8, 7}, {1, 2, 3}, {10, -20, 30});
  ImageCycle<float> images = made::constant_images(grid, 2, 0);
  for (auto& phase : images.phases) {
    for (std::size_t v = 0; v < phase.size(); ++v) phase[v] = static_cast<float>(v);
  }
  const Box box{{2, 3, 1}, {4, 3, 5}};
  const ImageCycle<float> part = crop(images, box);
  EXPECT_EQ(part.grid.size, box.size);
  for (int k = 0; k < 5; ++k) {
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 4; ++i) {
        EXPECT_EQ(part.phases[1][part.grid.offset(i, j, k)],
                  images.phases[1][grid.offset(i + 2, j + 3, k + 1)]);
        EXPECT_LT((part.grid.mm(i, j, k) - grid.mm(i + 2, j + 3, k + 1)).norm(), 1e-9);
      }
    }
  }
}

}  // namespace
}  // namespace beatlas
