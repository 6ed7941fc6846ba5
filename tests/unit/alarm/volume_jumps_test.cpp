#include "pipeline/alarm/volume_jumps.h"

#include <cmath>

#include <gtest/gtest.h>

#include "pipeline/phantom/motion.h"

namespace beatlas::alarm {
namespace {

/// A ventricle that throws two thirds out, steeply, its first frame `delay_s` after the R wave.
std::vector<double> ventricle(int phases, double delay_s = 0) {
  std::vector<double> curve;
  for (int p = 0; p < phases; ++p) {
    curve.push_back(150 * (1 - 0.66 * phantom::volume_loss(p * 0.75 / phases + delay_s, 0.75)));
  }
  return curve;
}

TEST(VolumeJumps, SteepEjectionAndFillingAreNone) {
  for (const int phases : {6, 8, 10, 12, 15, 20, 25, 30, 50, 100}) {
    for (const double delay_s : {0.0, 0.02, 0.05}) {
      EXPECT_TRUE(volume_jumps(ventricle(phases, delay_s), 0.01).empty())
          << phases << " phases, " << delay_s << " s";
    }
  }
}

TEST(VolumeJumps, OnePhaseThatLeakedOrLostIsFoundWhereverItIs) {
  for (const int phases : {15, 25, 30}) {
    for (int leaked = 0; leaked < phases; ++leaked) {
      for (const double share : {0.5, -0.5}) {
        std::vector<double> curve = ventricle(phases);
        curve[static_cast<std::size_t>(leaked)] += share * curve[0];
        const std::vector<VolumeJump> jumps = volume_jumps(curve, 0.06);
        ASSERT_EQ(jumps.size(), 1U) << leaked << " of " << phases << ", " << share;
        EXPECT_EQ(jumps[0].worst, leaked) << phases;
        EXPECT_EQ(jumps[0].beyond > 0, share > 0);
        EXPECT_LE(std::abs(jumps[0].beyond), std::abs(share) + 1e-9);
      }
    }
  }
}

TEST(VolumeJumps, ARunOfPhasesIsOneJump) {
  std::vector<double> curve = ventricle(25);
  for (const std::size_t p : {23U, 24U, 0U}) curve[p] += 40;
  const std::vector<VolumeJump> jumps = volume_jumps(curve, 0.06);
  ASSERT_EQ(jumps.size(), 1U);
  EXPECT_EQ(jumps[0].first, 23);
  EXPECT_EQ(jumps[0].count, 3);
}

TEST(VolumeJumps, TwoLeaksAreTwo) {
  std::vector<double> curve = ventricle(20);
  curve[4] += 60;
  curve[17] -= 30;
  const std::vector<VolumeJump> jumps = volume_jumps(curve, 0.06);
  ASSERT_EQ(jumps.size(), 2U);
  EXPECT_EQ(jumps[0].worst + jumps[1].worst, 21);
}

TEST(VolumeJumps, CurvesThatTellNothingHaveNone) {
  EXPECT_TRUE(volume_jumps({}, 0.06).empty());
  EXPECT_TRUE(volume_jumps({150, 50}, 0.06).empty());
  EXPECT_TRUE(volume_jumps({150, 150, 50, 150}, 0.06).empty());
  EXPECT_TRUE(volume_jumps(std::vector<double>(10, 0.0), 0.06).empty());
  EXPECT_EQ(closing_step({150, 50}), 0);
}

TEST(ClosingStep, IsWhatGrewFromPhaseToPhaseAndNoBeat) {
  for (const int phases : {10, 15, 25, 50}) {
    std::vector<double> curve = ventricle(phases);
    EXPECT_LT(closing_step(curve), 0.01) << phases;
    for (int p = 0; p < phases; ++p) {
      curve[static_cast<std::size_t>(p)] += 40.0 * p / (phases - 1);
    }
    // 40 ml of 190; the last phases fill besides, some of it in one step.
    EXPECT_GT(closing_step(curve), 0.1) << phases;
  }
}

}  // namespace
}  // namespace beatlas::alarm
