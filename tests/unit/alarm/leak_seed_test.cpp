/// The seed offered for a leak lies in what leaked, in no wall.
#include "pipeline/alarm/leak_seed.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <gtest/gtest.h>

namespace beatlas::alarm {
namespace {

/// A heart: discs of the RV's wall and fat around muscle around blood, in 3 slices and 3 phases.
/// @param rest_mm, muscle_mm thicknesses on the left (-x); on the right 3 and 9
LabelCycle disc(double rest_mm, double muscle_mm) {
  LabelCycle out;
  out.grid.size = {90, 60, 3};
  out.grid.mm_from_index = Affine::Identity();
  out.grid.mm_from_index.linear() = Vec3(1, 1, 8).asDiagonal();
  std::vector<std::uint8_t> image(out.grid.count(), kLabelBackground);
  std::size_t v = 0;
  for (int k = 0; k < 3; ++k) {
    for (int j = 0; j < 60; ++j) {
      for (int i = 0; i < 90; ++i, ++v) {
        const double x = i - 55;
        const double r = std::hypot(x, j - 30.0);
        const bool left = x < 0 && std::abs(j - 30) < 10;
        const double muscle = 12 + (left ? muscle_mm : 9);
        if (r < 12) {
          image[v] = kLabelLvBlood;
        } else if (r < muscle) {
          image[v] = kLabelLvMyocardium;
        } else if (r < muscle + (left ? rest_mm : 3)) {
          image[v] = kLabelRestOfHeart;
        }
      }
    }
  }
  out.phases.assign(3, image);
  return out;
}

/// On the surface at the left, in phase 1.
LeakAlarm at_left(double rest_mm, double muscle_mm, LeakKind kind = LeakKind::NoEdge) {
  return {kind, Structure::Heart, 1, Vec3(55 - 12 - muscle_mm - rest_mm, 30, 8), 500, 200, ""};
}

std::optional<LeakSeed> under(const LeakAlarm& alarm, const LabelCycle& labels) {
  return seed_under(alarm, alarm.lps_mm, labels);
}

TEST(SeedUnder, LiesInTheMiddleOfWhatIsMoreThanAWall) {
  const auto seed = under(at_left(20, 9), disc(20, 9));
  ASSERT_TRUE(seed);
  EXPECT_EQ(seed->label, kLabelBackground);
  EXPECT_EQ(seed->phase, -1);
  // 20 mm of rest, of which 5 may be a wall.
  EXPECT_NEAR((seed->lps_mm - Vec3(14 + 7.5, 30, 8)).norm(), 0, 1.5);
  EXPECT_NEAR(seed->radius_mm, 6, 1e-9);
}

TEST(SeedUnder, LiesRightUnderTheSurfaceOfAHeartWithoutChambers) {
  LabelCycle labels = disc(20, 9);
  for (auto& phase : labels.phases) {
    for (auto& label : phase) {
      if (label != kLabelBackground) label = kLabelRestOfHeart;
    }
  }
  const auto seed = under(at_left(20, 9), labels);
  ASSERT_TRUE(seed);
  EXPECT_NEAR((seed->lps_mm - Vec3(14 + 6, 30, 8)).norm(), 0, 1.5);
  EXPECT_NEAR(seed->radius_mm, 6, 1e-9);
}

TEST(SeedUnder, IsOfOnePhaseWhereThePlaceIsMuscleInAnother) {
  LabelCycle labels = disc(20, 9);
  labels.phases[2] = disc(0, 25).phases[0];
  const auto seed = under(at_left(20, 9), labels);
  ASSERT_TRUE(seed);
  EXPECT_EQ(seed->phase, 1);
}

TEST(SeedUnder, IsNotOfferedWhereAWallLiesUnderTheSurface) {
  EXPECT_FALSE(under(at_left(4, 9), disc(4, 9)));
  EXPECT_FALSE(under(at_left(0, 12), disc(0, 12))) << "the LV's wall against the diaphragm";
  EXPECT_TRUE(under(at_left(0, 26), disc(0, 26))) << "no LV is as thick";
  EXPECT_TRUE(under(at_left(0, 12, LeakKind::Air), disc(0, 12))) << "lung is no wall";
  LeakAlarm of_blood = at_left(20, 9);
  of_blood.structure = Structure::LvBlood;
  EXPECT_FALSE(under(of_blood, disc(20, 9)));
}

TEST(SeedBeside, IsWhatThePhasesBesideSay) {
  LabelCycle labels = disc(3, 9);
  labels.phases[1] = disc(20, 9).phases[0];
  LeakAlarm jump = at_left(10, 9, LeakKind::VolumeJump);
  const auto seed = seed_beside(jump, labels, 0, 2);
  ASSERT_TRUE(seed);
  EXPECT_EQ(seed->label, kLabelBackground);
  EXPECT_EQ(seed->phase, 1);
  EXPECT_EQ(seed->lps_mm, jump.lps_mm);
  jump.lps_mm = Vec3(55, 30, 8);
  EXPECT_FALSE(seed_beside(jump, labels, 0, 2)) << "blood in all";
  labels.phases[2] = labels.phases[1];
  jump.lps_mm = at_left(10, 9).lps_mm;
  EXPECT_FALSE(seed_beside(jump, labels, 0, 2)) << "they do not agree";
}

TEST(SeedBeside, OfAnAtriumIsOfTheRestOfTheHeart) {
  const LeakAlarm jump = at_left(10, 9, LeakKind::VolumeJump);
  LabelCycle labels = disc(3, 9);
  for (const int phase : {0, 2}) {
    auto& image = labels.phases[static_cast<std::size_t>(phase)];
    std::fill(image.begin(), image.end(), std::uint8_t{kLabelLaBlood});
  }
  const auto seed = seed_beside(jump, labels, 0, 2);
  ASSERT_TRUE(seed) << "phase 1 has none there";
  EXPECT_EQ(seed->label, kLabelRestOfHeart) << "a label that seeds may have";
  std::fill(labels.phases[1].begin(), labels.phases[1].end(), std::uint8_t{kLabelRestOfHeart});
  EXPECT_FALSE(seed_beside(jump, labels, 0, 2)) << "no seed tells these apart";
}

}  // namespace
}  // namespace beatlas::alarm
