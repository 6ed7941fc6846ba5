#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "pipeline/segment/drawn_seeds.h"
#include "pipeline/segment/followed_seeds.h"
#include "runtime/atlas/structures.h"
#include "tests/made_images.h"

namespace beatlas::segment {
namespace {

const Grid kOblique = made::oblique_grid({40, 36, 24}, {1.2, 1.2, 2.5}, {35, -12, 60});

LabelImages blank(const Grid& grid, int phases) {
  return LabelImages(static_cast<std::size_t>(phases),
                     std::vector<std::uint8_t>(grid.count(), kUnlabelled));
}

TEST(DoubtfulSeeds, AreThoseThatImagesSpeakAgainst) {
  tissue::TissueLevels levels;
  levels.blood = 300;
  levels.muscle = 100;
  levels.dark = 50;
  ImageCycle<float> images{kOblique, {}};
  images.phases.assign(2, std::vector<float>(kOblique.count(), 300.0F));
  std::fill(images.phases[1].begin(), images.phases[1].end(), 100.0F);
  const Vec3 here = kOblique.mm(20, 18, 12);
  const auto doubts = [&](std::uint8_t label, int phase) {
    return doubtful_seeds(images, {{label, here, 3.0, phase}}, levels);
  };
  EXPECT_TRUE(doubts(kLabelLvBlood, 0).empty());
  EXPECT_TRUE(doubts(kLabelBackground, 0).empty()) << "background is anything";
  EXPECT_TRUE(doubts(kLabelRestOfHeart, 0).empty()) << "so is the rest, but lung";
  ASSERT_EQ(doubts(kLabelLvBlood, 1).size(), 1U);
  EXPECT_NE(doubts(kLabelLvBlood, 1)[0].find("seed 1, lv_blood at ("), std::string::npos);
  EXPECT_NE(doubts(kLabelLvBlood, 1)[0].find("phase 1, lies where the image is as dark as muscle"),
            std::string::npos);
  EXPECT_EQ(doubts(kLabelLvMyocardium, 0).size(), 1U) << "as bright as blood";
  EXPECT_TRUE(doubts(kLabelLvMyocardium, 1).empty());
  std::fill(images.phases[1].begin(), images.phases[1].end(), 20.0F);
  EXPECT_EQ(doubts(kLabelRestOfHeart, 1).size(), 1U) << "lung";
  const std::vector<Seed> many(9, Seed{kLabelLvBlood, here, 3.0, 1});
  const std::vector<std::string> some = doubtful_seeds(images, many, levels);
  EXPECT_EQ(some.size(), 5U);
  EXPECT_NE(some.back().find("the same of 4 more seeds"), std::string::npos);
  // What was painted has no number that could be taken out, and moves none.
  Seed run{kLabelLvBlood, here, 3.0, 1};
  run.painted = true;
  const std::vector<std::string> mixed =
      doubtful_seeds(images, {{kLabelLvBlood, here, 3.0, 1}, run}, levels);
  ASSERT_EQ(mixed.size(), 2U);
  EXPECT_NE(mixed[0].find("remove 1"), std::string::npos);
  EXPECT_EQ(mixed[1].rfind("what is painted, lv_blood at (", 0), 0U) << mixed[1];
  EXPECT_NE(mixed[1].find("paint it anew"), std::string::npos);
  EXPECT_EQ(mixed[1].find("remove"), std::string::npos) << mixed[1];
}

TEST(SeedsNotFollowed, GivenLabelsAreNamedWhereTheyStay) {
  const Vec3 here = kOblique.mm(20, 18, 12);
  const std::vector<Seed> seeds{{kLabelRvBlood, here, 3.0, 1}};
  const ImageCycle<std::uint8_t> all_lv{
      kOblique, LabelImages(2, std::vector<std::uint8_t>(kOblique.count(), kLabelLvBlood))};
  ImageCycle<std::uint8_t> followed = all_lv;
  followed.phases[1].assign(kOblique.count(), kLabelRvBlood);
  LabelImages marks = blank(kOblique, 2);
  draw_seeds(kOblique, seeds, marks);
  const auto told = [&](const auto& grown, const auto& labels) {
    const std::vector<std::string> out = seeds_not_followed(grown, labels, seeds, marks);
    return out.size() == 1 ? out.front() : std::string();
  };
  EXPECT_NE(told(all_lv, all_lv).find("it was taken for lv_blood"), std::string::npos);
  EXPECT_NE(told(followed, all_lv).find("labels that were given there stay"), std::string::npos);
  EXPECT_EQ(told(followed, followed), "");
}

TEST(DrawSeeds, PaintsTheVoxelsWhoseCentresLieInTheBall) {
  const Vec3 centre = kOblique.mm(17.3, 20.8, 11.4);
  const Seed seed{kLabelLvBlood, centre, 7.0, 1};
  LabelImages images = blank(kOblique, 3);
  draw_seeds(kOblique, {seed}, images);
  int painted = 0;
  for (int k = 0; k < kOblique.size[2]; ++k) {
    for (int j = 0; j < kOblique.size[1]; ++j) {
      for (int i = 0; i < kOblique.size[0]; ++i) {
        const double away = (kOblique.mm(i, j, k) - centre).norm();
        const std::uint8_t value = images[1][kOblique.offset(i, j, k)];
        if (std::abs(away - 7.0) < 1e-6) continue;
        EXPECT_EQ(value, away < 7.0 ? std::uint8_t{kLabelLvBlood} : kUnlabelled)
            << i << " " << j << " " << k;
        painted += value == kLabelLvBlood;
        EXPECT_EQ(images[0][kOblique.offset(i, j, k)], kUnlabelled);
        EXPECT_EQ(images[2][kOblique.offset(i, j, k)], kUnlabelled);
      }
    }
  }
  // 4/3 pi 7^3 mm3 in voxels of 3.6 mm3; the count of a ball's voxels is within a few percent.
  EXPECT_NEAR(painted, 4.0 / 3.0 * M_PI * 343 / 3.6, 30);
}

TEST(DrawSeeds, OfPhaseMinusOneStandInEveryPhase) {
  LabelImages images = blank(kOblique, 4);
  draw_seeds(kOblique, {{kLabelRvBlood, kOblique.mm(10, 10, 10), 3.0, -1}}, images);
  for (const auto& image : images) EXPECT_EQ(image[kOblique.offset(10, 10, 10)], kLabelRvBlood);
}

TEST(DrawSeeds, SmallerThanAVoxelStillMarkTheOneTheyLieIn) {
  // Thick slices: between two of them no voxel centre is near, wherever in the voxel the seed is.
  const Grid thick = made::oblique_grid({20, 20, 6}, {1.4, 1.4, 10}, {0, 0, 0});
  for (const Vec3& off : {Vec3(0, 0, 0), Vec3(0.49, 0.49, 0.49), Vec3(-0.49, 0.3, 0.45),
                          Vec3(0.2, -0.2, -0.49), Vec3(0.45, 0.45, 0.1)}) {
    for (double radius : {0.1, 0.5, 2.0}) {
      LabelImages images = blank(thick, 1);
      const Vec3 at = Vec3(9, 8, 3) + off;
      draw_seeds(thick, {{kLabelLvBlood, thick.mm(at[0], at[1], at[2]), radius, 0}}, images);
      EXPECT_EQ(images[0][thick.offset(9, 8, 3)], kLabelLvBlood)
          << off.transpose() << " radius " << radius;
    }
  }
}

TEST(DrawSeeds, ReplaceTheAutomaticOnesOfTheirLabelSliceAndPhaseOnly) {
  LabelImages images = blank(kOblique, 2);
  images[0][kOblique.offset(1, 1, 12)] = kLabelLvBlood;     // same slice and phase: replaced
  images[0][kOblique.offset(1, 1, 1)] = kLabelLvBlood;      // another slice
  images[1][kOblique.offset(2, 1, 12)] = kLabelLvBlood;     // another phase
  images[0][kOblique.offset(3, 1, 12)] = kLabelBackground;  // another label
  draw_seeds(kOblique, {{kLabelLvBlood, kOblique.mm(20, 20, 12), 3.0, 0}}, images);
  EXPECT_EQ(images[0][kOblique.offset(20, 20, 12)], kLabelLvBlood);
  EXPECT_EQ(images[0][kOblique.offset(1, 1, 12)], kUnlabelled);
  EXPECT_EQ(images[0][kOblique.offset(1, 1, 1)], kLabelLvBlood);
  EXPECT_EQ(images[1][kOblique.offset(2, 1, 12)], kLabelLvBlood);
  EXPECT_EQ(images[0][kOblique.offset(3, 1, 12)], kLabelBackground);
}

TEST(DrawSeeds, OfBackgroundAddToTheAutomaticOnes) {
  LabelImages images = blank(kOblique, 1);
  images[0][kOblique.offset(1, 1, 12)] = kLabelBackground;
  draw_seeds(kOblique, {{kLabelBackground, kOblique.mm(20, 20, 12), 3.0, 0}}, images);
  EXPECT_EQ(images[0][kOblique.offset(20, 20, 12)], kLabelBackground);
  EXPECT_EQ(images[0][kOblique.offset(1, 1, 12)], kLabelBackground);
}

TEST(DrawSeeds, DrawnLaterLieOnEarlierOnes) {
  LabelImages images = blank(kOblique, 1);
  const Vec3 at = kOblique.mm(12, 12, 12);
  draw_seeds(kOblique, {{kLabelLvBlood, at, 6.0, 0}, {kLabelLvMyocardium, at, 2.0, 0}}, images);
  EXPECT_EQ(images[0][kOblique.offset(12, 12, 12)], kLabelLvMyocardium);
  EXPECT_EQ(images[0][kOblique.offset(15, 12, 12)], kLabelLvBlood);
}

TEST(DrawSeeds, OutsideTheImagesAreRefusedWithTheirPlace) {
  for (const Vec3& lps : {Vec3(1000, 0, 0), kOblique.mm(-8, 10, 10), Vec3(1e300, -1e300, 5),
                          Vec3(std::nan(""), 0, 0)}) {
    LabelImages images = blank(kOblique, 2);
    const std::string said = made::refusal([&] {
      draw_seeds(kOblique, {{kLabelLvBlood, lps, 2.0, 0}}, images);
    });
    EXPECT_NE(said.find("outside the images"), std::string::npos) << said;
    EXPECT_NE(said.find("LPS"), std::string::npos) << said;
  }
}

TEST(DrawSeeds, AStrokeMarksWhatLiesWithinItsRadiusOfItsLine) {
  const Vec3 a = kOblique.mm(8.2, 9.1, 6.3);
  const Vec3 b = kOblique.mm(24.6, 13.4, 9.8);
  const Vec3 c = kOblique.mm(26.1, 27.9, 17.5);
  const double radius = 3.5;  // more than half a voxel along every axis
  LabelImages images = blank(kOblique, 2);
  draw_seeds(kOblique, {{kLabelLvMyocardium, a, radius, 1, {b, c}}}, images);
  const auto away_from = [](const Vec3& from, const Vec3& to, const Vec3& at) {
    const double t = std::clamp((at - from).dot(to - from) / (to - from).squaredNorm(), 0.0, 1.0);
    return (from + t * (to - from) - at).norm();
  };
  int painted = 0;
  for (int k = 0; k < kOblique.size[2]; ++k) {
    for (int j = 0; j < kOblique.size[1]; ++j) {
      for (int i = 0; i < kOblique.size[0]; ++i) {
        const Vec3 at = kOblique.mm(i, j, k);
        const double away = std::min(away_from(a, b, at), away_from(b, c, at));
        const std::uint8_t value = images[1][kOblique.offset(i, j, k)];
        if (std::abs(away - radius) < 1e-6) continue;
        EXPECT_EQ(value, away < radius ? std::uint8_t{kLabelLvMyocardium} : kUnlabelled)
            << i << " " << j << " " << k;
        painted += value == kLabelLvMyocardium;
        EXPECT_EQ(images[0][kOblique.offset(i, j, k)], kUnlabelled);
      }
    }
  }
  EXPECT_GT(painted, 400);
}

TEST(DrawSeeds, AThinStrokeHasNoGaps) {
  // Across thick slices and along the plane between two of them: every voxel that the line passes
  // through is marked, wherever it is asked.
  const Grid thick = made::oblique_grid({40, 40, 8}, {1.4, 1.4, 10}, {3, 5, -20});
  const std::vector<Vec3> places = {
      {2.3, 3.1, 0.4}, {37.2, 9.6, 2.5}, {30.1, 36.4, 2.5}, {4.4, 20.2, 6.9}};
  std::vector<Vec3> through;
  for (const Vec3& place : places) through.push_back(thick.mm(place[0], place[1], place[2]));
  LabelImages images = blank(thick, 1);
  draw_seeds(thick, {{kLabelRvBlood, through[0], 0.1, 0, {through[1], through[2], through[3]}}},
             images);
  for (std::size_t s = 0; s + 1 < places.size(); ++s) {
    for (int step = 0; step <= 3000; ++step) {
      const Vec3 at = places[s] + (places[s + 1] - places[s]) * step / 3000.0;
      const Index3 voxel{static_cast<int>(std::lround(at[0])), static_cast<int>(std::lround(at[1])),
                         static_cast<int>(std::lround(at[2]))};
      ASSERT_EQ(images[0][thick.offset(voxel[0], voxel[1], voxel[2])], kLabelRvBlood)
          << at.transpose();
    }
  }
  const auto marked = std::count(images[0].begin(), images[0].end(), kLabelRvBlood);
  EXPECT_LT(marked, 400) << "a line, and no more than the voxels beside it";
}

TEST(DrawSeeds, AStrokeThatLeavesTheImagesIsRefusedWithThePlace) {
  const Seed seed{kLabelLvBlood, kOblique.mm(10, 10, 10), 2.0, 0, {kOblique.mm(-9, 10, 10)}};
  const std::string said = made::refusal([&] { check_seeds({seed}, kOblique, 2); });
  EXPECT_NE(said.find("outside the images"), std::string::npos) << said;
}

TEST(DrawSeeds, OfNoKnownLabelAreRefused) {
  LabelImages images = blank(kOblique, 2);
  const std::string said = made::refusal([&] {
    draw_seeds(kOblique, {{5, kOblique.mm(10, 10, 10), 2.0, 0}}, images);
  });
  EXPECT_NE(said.find("label 5"), std::string::npos) << said;
}

TEST(DrawSeeds, OfNoKnownPhaseAreRefused) {
  for (int phase : {2, -2}) {
    LabelImages images = blank(kOblique, 2);
    const std::string said = made::refusal([&] {
      draw_seeds(kOblique, {{kLabelLvBlood, kOblique.mm(10, 10, 10), 2.0, phase}}, images);
    });
    EXPECT_NE(said.find("phase " + std::to_string(phase)), std::string::npos) << said;
  }
}

TEST(DrawSeeds, OfNoSizeAreRefused) {
  for (double radius : {-1.0, 0.0, std::nan(""), 1e300 * 1e300}) {
    LabelImages images = blank(kOblique, 2);
    const std::string said = made::refusal([&] {
      draw_seeds(kOblique, {{kLabelLvBlood, kOblique.mm(10, 10, 10), radius, 0}}, images);
    });
    EXPECT_NE(said.find("radius"), std::string::npos) << said;
  }
}

}  // namespace
}  // namespace beatlas::segment
