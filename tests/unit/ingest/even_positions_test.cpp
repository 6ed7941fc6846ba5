#include "pipeline/ingest/even_positions.h"

#include <gtest/gtest.h>

#include "runtime/base/error.h"

namespace beatlas::ingest {
namespace {

TEST(EvenPositions, EvenStackIsTakenWhole) {
  const auto stack = find_even_stack({1, 9, 17, 25});
  EXPECT_EQ(stack.members, (std::vector<int>{0, 1, 2, 3}));
  EXPECT_DOUBLE_EQ(stack.spacing_mm, 8);
  EXPECT_DOUBLE_EQ(stack.first_mm, 1);
}

TEST(EvenPositions, PrintedRoundingAveragesOut) {
  const auto stack = find_even_stack({0, 8.03, 15.98, 24.02, 32});
  EXPECT_DOUBLE_EQ(stack.spacing_mm, 8) << "end to end";
}

TEST(EvenPositions, StrayAmongManyIsLeft) {
  const auto stack = find_even_stack({0, 10, 13, 20, 30, 40, 50});
  EXPECT_EQ(stack.members, (std::vector<int>{0, 1, 3, 4, 5, 6}));
  EXPECT_DOUBLE_EQ(stack.spacing_mm, 10);
}

TEST(EvenPositions, HolesAndFewSlicesAreRefused) {
  EXPECT_THROW((void)find_even_stack({0, 10, 20, 40, 50, 60}), Error);
  EXPECT_THROW((void)find_even_stack({0, 10, 20, 40}), Error);
  EXPECT_THROW((void)find_even_stack({0, 10, 23, 31}), Error);
  EXPECT_THROW((void)find_even_stack({0, 10}), Error);
}

TEST(EvenPositions, AMissingSliceLeavesAHoleWhereThatIsAllowed) {
  const auto stack = find_even_stack({0, 10, 20, 40, 50, 60}, Spacing::WithHoles);
  EXPECT_EQ(stack.members, (std::vector<int>{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(stack.numbers, (std::vector<int>{0, 1, 2, 4, 5, 6}));
  EXPECT_DOUBLE_EQ(stack.spacing_mm, 10);
  EXPECT_DOUBLE_EQ(stack.worst_gap, 0) << "a hole is no uneven gap";
  EXPECT_EQ(find_even_stack({0, 10, 20, 30}, Spacing::WithHoles).numbers,
            (std::vector<int>{0, 1, 2, 3}));
  EXPECT_EQ(find_even_stack({0, 16, 24, 32, 40}, Spacing::WithHoles).numbers,
            (std::vector<int>{0, 2, 3, 4, 5}));
  EXPECT_THROW((void)find_even_stack({0, 10, 20, 50, 60, 70}, Spacing::WithHoles), Error)
      << "two slices are missing side by side";
  EXPECT_THROW((void)find_even_stack({0, 10, 30, 40, 60, 70}, Spacing::WithHoles), Error)
      << "two of eight are missing";
  EXPECT_THROW((void)find_even_stack({0, 17, 34, 68, 85, 102}, Spacing::WithHoles), Error)
      << "too wide a hole";
  EXPECT_THROW((void)find_even_stack({0, 10, 23, 33}, Spacing::WithHoles), Error);
}

TEST(EvenPositions, LooseSlicesLieAboutEvenPlaces) {
  const std::vector<double> off{0, 10, 20, 31.5, 40, 50};
  EXPECT_THROW((void)find_even_stack(off), Error);
  const auto stack = find_even_stack(off, Spacing::Loose);
  EXPECT_EQ(stack.numbers, (std::vector<int>{0, 1, 2, 3, 4, 5}));
  EXPECT_NEAR(stack.spacing_mm, 10, 0.1);
  EXPECT_NEAR(stack.worst_off_mm, 1.2, 0.1) << "the others move a little too";
  const auto blocks = find_even_stack({0, 10, 20, 33, 43, 53}, Spacing::Loose);
  EXPECT_NEAR(blocks.spacing_mm, 10.8, 0.05) << "least squares";
  EXPECT_NEAR(blocks.first_mm, -0.4, 0.05);
  EXPECT_EQ(find_even_stack({0, 10, 20, 41, 50, 60}, Spacing::Loose).numbers,
            (std::vector<int>{0, 1, 2, 4, 5, 6}));
  EXPECT_THROW((void)find_even_stack({0, 10, 20, 50, 60, 70}, Spacing::Loose), Error);
  EXPECT_THROW((void)find_even_stack({0, 10, 20, 24, 34, 44}, Spacing::Loose), Error);
  EXPECT_THROW((void)find_even_stack({0, 10, 20, 36, 46, 56}, Spacing::Loose), Error)
      << "a slice may be missing or not";
  EXPECT_THROW((void)find_even_stack({0, 8}, Spacing::Loose), Error);
}

TEST(EvenPositions, UnevenWithinATenthTakesTheMedian) {
  const auto stack = find_even_stack({0, 8.4, 16.4, 24.4});
  EXPECT_DOUBLE_EQ(stack.spacing_mm, 8);
  EXPECT_NEAR(stack.worst_gap, 0.05, 1e-12);
  EXPECT_NEAR(stack.first_mm, 0.3, 1e-12) << "off by nothing on average";
}

TEST(EvenPositions, StacksThatInterleaveArePartsPartsOfOneAreNot) {
  using Parts = std::vector<std::vector<int>>;
  EXPECT_EQ(even_parts({0, 3, 8, 11, 16, 19}), (Parts{{0, 2, 4}, {1, 3, 5}}));
  EXPECT_EQ(even_parts({0, 8, 16, 24}), Parts());
  EXPECT_EQ(even_parts({0, 8, 16, 32, 40, 48}), Parts()) << "a hole";
  EXPECT_EQ(even_parts({0, 3, 8, 11, 16}), Parts()) << "two are no stack";
}

}  // namespace
}  // namespace beatlas::ingest
