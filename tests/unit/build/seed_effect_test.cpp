/// What a correction changed beside what it is for is told in ml.
#include "pipeline/build/seed_effect.h"

#include <gtest/gtest.h>

namespace beatlas::build {
namespace {

/// Voxels of 0.001 ml in 4 phases, all rest of the heart.
LabelCycle all_heart() {
  LabelCycle out;
  out.grid.size = {20, 20, 4};
  out.grid.mm_from_index = Affine::Identity();
  out.phases.assign(4, std::vector<std::uint8_t>(out.grid.count(), kLabelRestOfHeart));
  return out;
}

void paint(LabelCycle& labels, std::size_t phase, const Index3& low, const Index3& high,
           std::uint8_t label) {
  for (int k = low[2]; k <= high[2]; ++k) {
    for (int j = low[1]; j <= high[1]; ++j) {
      for (int i = low[0]; i <= high[0]; ++i) {
        labels.phases[phase][labels.grid.offset(i, j, k)] = label;
      }
    }
  }
}

const std::vector<LeakSeed> kSeed{{kLabelBackground, Vec3(5, 5, 1), 1, 1}};

TEST(ChangedElsewhere, IsNothingWhereAllHangsTogetherWithTheSeed) {
  const LabelCycle before = all_heart();
  LabelCycle after = before;
  paint(after, 1, {4, 4, 1}, {12, 12, 2}, kLabelBackground);
  paint(after, 2, {9, 9, 2}, {14, 14, 3}, kLabelBackground);
  EXPECT_EQ(changed_elsewhere_ml(before, before, kSeed), 0);
  EXPECT_EQ(changed_elsewhere_ml(before, after, kSeed), 0) << "through space and time";
}

TEST(ChangedElsewhere, IsTheLargestChangeOfALabelInAPhase) {
  const LabelCycle before = all_heart();
  LabelCycle after = before;
  paint(after, 1, {4, 4, 1}, {6, 6, 1}, kLabelBackground);
  paint(after, 3, {10, 0, 0}, {13, 4, 0}, kLabelRvBlood);
  paint(after, 1, {15, 15, 3}, {16, 16, 3}, kLabelBackground);
  EXPECT_NEAR(changed_elsewhere_ml(before, after, kSeed), 0.020, 1e-12);
  EXPECT_NEAR(changed_elsewhere_ml(before, after, {}), 0.020, 1e-12);
}

TEST(ChangedElsewhere, DoesNotCountLabelsThatChangePlaces) {
  LabelCycle before = all_heart();
  LabelCycle after = before;
  paint(before, 0, {15, 2, 0}, {15, 6, 0}, kLabelRvBlood);
  paint(after, 0, {16, 2, 0}, {16, 6, 0}, kLabelRvBlood);
  EXPECT_EQ(changed_elsewhere_ml(before, after, kSeed), 0);
}

TEST(ChangedElsewhere, BeginsInThePhaseOfTheSeed) {
  const LabelCycle before = all_heart();
  LabelCycle after = before;
  paint(after, 3, {4, 4, 1}, {6, 6, 1}, kLabelBackground);
  EXPECT_NEAR(changed_elsewhere_ml(before, after, kSeed), 0.009, 1e-12);
  std::vector<LeakSeed> always = kSeed;
  always.front().phase = -1;
  EXPECT_EQ(changed_elsewhere_ml(before, after, always), 0);
}

}  // namespace
}  // namespace beatlas::build
