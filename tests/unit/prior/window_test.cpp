#include "pipeline/prior/window.h"

#include <gtest/gtest.h>

#include "runtime/atlas/structures.h"

namespace beatlas::prior {
namespace {

/// Sure of background in two phases of which one was looked at; pixels of 5 mm, slices of 10.
class Looked {
 public:
  Looked() {
    prior_.grid.size = {80, 64, 12};
    prior_.grid.mm_from_index.linear() = Vec3(5, 5, 10).asDiagonal();
    prior_.labels = {kLabelBackground, kLabelLvBlood, kLabelRvBlood};
    prior_.phases.resize(2);
    prior_.phases[1].assign(3 * prior_.grid.count(), -128);
    std::fill_n(prior_.phases[1].begin(), prior_.grid.count(), std::int8_t{-16});
  }
  /// @param output 1: LV's blood, 2: RV's
  void fill(std::size_t output, const Index3& low, const Index3& high) {
    for (int k = low[2]; k <= high[2]; ++k) {
      for (int j = low[1]; j <= high[1]; ++j) {
        for (int i = low[0]; i <= high[0]; ++i) {
          prior_.phases[1][output * prior_.grid.count() + prior_.grid.offset(i, j, k)] = -2;
        }
      }
    }
  }
  [[nodiscard]] Window window(int multiple) const { return window_of_heart(prior_, multiple); }

 private:
  PriorCycle prior_;
};

TEST(PriorWindow, HoldsTheHeartAnd25MmBesideIt) {
  Looked looked;
  looked.fill(1, {30, 30, 4}, {35, 34, 7});
  looked.fill(2, {36, 30, 5}, {39, 32, 6});  // hangs together with it
  looked.fill(2, {70, 5, 1}, {75, 9, 2});    // and this does not
  const Window window = looked.window(1);
  EXPECT_EQ(window.first, (Index3{25, 25, 1}));
  EXPECT_EQ(window.size, (Index3{20, 15, 10}));
}

TEST(PriorWindow, IsAMultipleWhereTheLatticeHasRoom) {
  Looked looked;
  looked.fill(1, {70, 30, 4}, {79, 34, 7});
  const Window window = looked.window(16);
  EXPECT_EQ(window.first, (Index3{64, 25, 1}));
  EXPECT_EQ(window.size, (Index3{16, 16, 10}));
}

TEST(PriorWindow, HoldsEveryBodyThatMayBeTheHeart) {
  Looked looked;
  looked.fill(1, {10, 30, 4}, {19, 39, 6});
  looked.fill(1, {50, 30, 4}, {59, 36, 6});  // seven tenths of its blood
  looked.fill(1, {70, 60, 4}, {73, 63, 6});  // a sixth
  const Window window = looked.window(1);
  EXPECT_EQ(window.first[0], 5);
  EXPECT_EQ(window.size[0], 60);
}

TEST(PriorWindow, IsAllOfTheLatticeWhereNoHeartIsSeen) {
  Looked looked;
  looked.fill(2, {10, 30, 4}, {19, 39, 6});
  EXPECT_EQ(looked.window(16).size, (Index3{80, 64, 12}));
  EXPECT_EQ(Looked().window(16).size, (Index3{80, 64, 12}));
}

TEST(PriorWindow, ThreePhasesOfABeatAreLookedAt) {
  EXPECT_EQ(looked_at(25), (std::vector<int>{0, 8, 16}));
  EXPECT_EQ(looked_at(2), (std::vector<int>{0, 1}));
  EXPECT_EQ(looked_at(1), (std::vector<int>{0}));
}

}  // namespace
}  // namespace beatlas::prior
