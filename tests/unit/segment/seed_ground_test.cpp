/// A heart that marks alone tell, on discs and rings in closed form.
#include "pipeline/segment/seed_ground.h"

#include <cmath>

#include <gtest/gtest.h>

#include "pipeline/core/box.h"
#include "pipeline/segment/drawn_seeds.h"
#include "pipeline/segment/segment.h"
#include "pipeline/tissue/tissue.h"
#include "tests/made_images.h"

namespace beatlas::segment {
namespace {

constexpr int kPhases = 4;
constexpr int kFirst = 1;  ///< slices with a heart
constexpr int kLast = 6;

/// Half the swing of the cavity's radius is 3 mm; all else stands still.
double cavity_mm(int phase) { return 20 + 3 * std::cos(2 * M_PI * phase / kPhases); }

/// A round LV in a wall that ends at 31 mm, an RV as a disc beside it that the wall cuts, lung
/// about, and liver as dark as muscle below.
std::uint8_t truth_at(double x, double y, int k, int phase) {
  if (k < kFirst || k > kLast) return kLabelBackground;
  const double r = std::hypot(x, y);
  if (r < cavity_mm(phase)) return kLabelLvBlood;
  if (r < 31) return kLabelLvMyocardium;
  return std::hypot(x + 36, y) < 22 ? kLabelRvBlood : kLabelBackground;
}

struct Drawn {
  Exam exam;
  LabelCycle truth;
};

Drawn drawn_heart() {
  Drawn out;
  const Grid grid = made::straight_grid({100, 84, 8}, {1.5, 1.5, 8});
  out.exam.stack.images = made::constant_images(grid, kPhases, 20);
  out.exam.stack.rr_interval_s = 1;
  out.truth = {grid, std::vector(kPhases, std::vector<std::uint8_t>(grid.count()))};
  for (int p = 0; p < kPhases; ++p) {
    out.exam.stack.frame_times_s.push_back(p * 1.0 / kPhases);
    for (int k = 0; k < grid.size[2]; ++k) {
      for (int j = 0; j < grid.size[1]; ++j) {
        for (int i = 0; i < grid.size[0]; ++i) {
          const double x = 1.5 * i - 85;
          const double y = 1.5 * j - 50;
          const std::uint8_t label = truth_at(x, y, k, p);
          float value = y > 40 ? 100.0F : 20.0F;
          if (label == kLabelLvMyocardium) value = 100;
          if (label == kLabelLvBlood || label == kLabelRvBlood) value = 300;
          const auto phase = static_cast<std::size_t>(p);
          out.truth.phases[phase][grid.offset(i, j, k)] = label;
          out.exam.stack.images.phases[phase][grid.offset(i, j, k)] = value;
        }
      }
    }
  }
  made::add_noise(out.exam.stack.images, 8, 5);
  return out;
}

/// A ball of each in three slices of the first phase.
std::vector<Seed> marks() {
  std::vector<Seed> out;
  for (const int k : {kFirst, 4, kLast}) {
    const auto at = [&](double x, double y) { return Vec3(x + 85, y + 50, 8.0 * k); };
    out.push_back({kLabelLvBlood, at(3, -2), 5, 0});
    out.push_back({kLabelLvMyocardium, at(0, 27), 2, 0});
    out.push_back({kLabelRvBlood, at(-44, 0), 4, 0});
    out.push_back({kLabelBackground, at(0, 48), 4, 0});
  }
  return out;
}

/// Least Dice of each phase.
void expect_found(const Drawn& made, const Segmentation& found, double lv, double muscle,
                  double rv) {
  for (std::size_t p = 0; p < kPhases; ++p) {
    const auto dice = [&](std::uint8_t label) {
      return made::label_dice(found.labels.phases[p], made.truth.phases[p], label);
    };
    EXPECT_GT(dice(kLabelLvBlood), lv) << p;
    EXPECT_GT(dice(kLabelLvMyocardium), muscle) << p;
    EXPECT_GT(dice(kLabelRvBlood), rv) << p;
  }
}

TEST(SeedGround, TwelveBallsOfOnePhaseTellTheHeartInAll) {
  const Drawn made = drawn_heart();
  StageContext context;
  const Segmentation found = segment_exam(made.exam, marks(), {}, context);
  expect_found(made, found, 0.93, 0.80, 0.85);
}

TEST(SeedGround, AMarkIsKeptWhateverTheImageShows) {
  const Drawn made = drawn_heart();
  std::vector<Seed> seeds = marks();
  seeds.push_back({kLabelLvBlood, Vec3(85 + 26, 50, 32), 4, 2});  // in the wall
  StageContext context;
  const Segmentation found = segment_exam(made.exam, seeds, {}, context);
  const Grid& grid = found.labels.grid;
  EXPECT_EQ(found.labels.phases[2][grid.offset(74, 33, 4)], kLabelLvBlood);
  for (const std::string& warning : found.warnings) {
    EXPECT_EQ(warning.find("automatic seed"), std::string::npos) << warning;
  }
}

TEST(SeedGround, NeedsBloodAndMuscleOfTheLvAndBackground) {
  const Drawn made = drawn_heart();
  const auto tell = [&](const std::vector<Seed>& seeds) {
    LabelImages drawn(made.truth.phases.size(),
                      std::vector<std::uint8_t>(made.truth.grid.count(), kUnlabelled));
    draw_seeds(made.truth.grid, seeds, drawn);
    return tell_heart(drawn, {});
  };
  std::vector<Seed> seeds = marks();
  EXPECT_TRUE(tell(seeds));
  std::erase_if(seeds, [](const Seed& seed) { return seed.label == kLabelLvMyocardium; });
  EXPECT_FALSE(tell(seeds));
}

/// The last mark on a place counts: what is left then may tell no heart.
TEST(SeedGround, OfAMarkThatCoversTheOnlyOneOfTheCavityAsksForAnother) {
  const Drawn made = drawn_heart();
  const Vec3 at = marks().front().lps_mm;
  const std::vector<Seed> seeds{{kLabelLvBlood, at, 3, 0},
                                {kLabelLvMyocardium, at, 4, 0},
                                {kLabelBackground, at + Vec3(60, 0, 0), 4, -1}};
  StageContext context;
  const std::string said =
      made::refusal([&] { (void)segment_exam(made.exam, seeds, {}, context); });
  EXPECT_NE(said.find("give seeds of the left ventricle's blood"), std::string::npos) << said;
}

/// A cavity that closes: blood at end-diastole and muscle at end-systole, at one place.
TEST(SeedGround, MarksOfOtherPhasesDoNotEraseEachOther) {
  const Drawn made = drawn_heart();
  std::vector<Seed> seeds = marks();
  LabelImages drawn(made.truth.phases.size(),
                    std::vector<std::uint8_t>(made.truth.grid.count(), kUnlabelled));
  const Vec3 at = seeds.front().lps_mm;
  draw_seeds(made.truth.grid,
             {{kLabelLvBlood, at, 3, 0},
              {kLabelLvMyocardium, at, 4, 1},
              {kLabelBackground, at + Vec3(60, 0, 0), 4, -1}},
             drawn);
  EXPECT_TRUE(tell_heart(drawn, {}));
  EXPECT_FALSE(box_of_marks(made.truth.grid, drawn).empty());
}

TEST(SeedGround, LabelsOfTwoPhasesTellTheHeartInTheOthers) {
  const Drawn made = drawn_heart();
  const KnownLabels known{{made.truth.grid, {made.truth.phases[0], made.truth.phases[2]}}, {0, 2}};
  EXPECT_TRUE(tell_heart(known.labels.phases, known));
  StageContext context;
  const Segmentation found = segment_exam(made.exam, {}, {}, context, known);
  expect_found(made, found, 0.95, 0.85, 0.90);
}

TEST(SeedGround, WithoutMarksOrAPriorSaysWhatToGive) {
  const Drawn made = drawn_heart();
  StageContext context;
  const std::string said =
      made::refusal([&] { (void)segment_exam(made.exam, {marks().front()}, {}, context); });
  EXPECT_NE(said.find("nothing tells where the heart is"), std::string::npos) << said;
  EXPECT_NE(said.find("--seeds"), std::string::npos) << said;
}

TEST(SeedGround, MuscleMarkedAsBrightAsBloodIsRefused) {
  const Drawn made = drawn_heart();
  std::vector<Seed> seeds = marks();
  for (Seed& seed : seeds) {
    if (seed.label == kLabelLvMyocardium) seed.lps_mm += Vec3(0, -20, 0);
  }
  StageContext context;
  EXPECT_NE(made::refusal([&] {
              (void)segment_exam(made.exam, seeds, {}, context);
            }).find("no darker than blood"),
            std::string::npos);
}

TEST(Boxes, WhatWasCroppedGoesBackToItsPlace) {
  const Grid grid = made::straight_grid({7, 6, 5}, {1, 1, 2});
  ImageCycle<std::uint8_t> whole{grid, {std::vector<std::uint8_t>(grid.count())}};
  const Box box{{2, 1, 1}, {3, 4, 2}};
  whole.phases[0][grid.offset(2, 1, 1)] = 3;
  whole.phases[0][grid.offset(4, 4, 2)] = 1;
  ImageCycle<std::uint8_t> again{grid, {}};
  put_back(crop(whole, box), box, again);
  EXPECT_EQ(again.phases, whole.phases);
}

}  // namespace
}  // namespace beatlas::segment
