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
  const auto stack = find_even_stack({0, 10, 20, 40, 50, 60}, Holes::OfOneSlice);
  EXPECT_EQ(stack.members, (std::vector<int>{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(stack.numbers, (std::vector<int>{0, 1, 2, 4, 5, 6}));
  EXPECT_DOUBLE_EQ(stack.spacing_mm, 10);
  EXPECT_DOUBLE_EQ(stack.worst_gap, 0) << "a hole is no uneven gap";
  EXPECT_EQ(find_even_stack({0, 10, 20, 30}, Holes::OfOneSlice).numbers,
            (std::vector<int>{0, 1, 2, 3}));
  EXPECT_EQ(find_even_stack({0, 16, 24, 32, 40}, Holes::OfOneSlice).numbers,
            (std::vector<int>{0, 2, 3, 4, 5}));
  EXPECT_THROW((void)find_even_stack({0, 10, 20, 50, 60, 70}, Holes::OfOneSlice), Error)
      << "two slices are missing side by side";
  EXPECT_THROW((void)find_even_stack({0, 10, 30, 40, 60, 70}, Holes::OfOneSlice), Error)
      << "two of eight are missing";
  EXPECT_THROW((void)find_even_stack({0, 10, 23, 33}, Holes::OfOneSlice), Error);
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
