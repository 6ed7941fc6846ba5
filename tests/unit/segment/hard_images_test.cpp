/// Images that are hard on the numerics: none may crash, hang or give what is no segmentation.
/// Their hearts are hollow balls, which marks alone tell.
#include <algorithm>
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "pipeline/alarm/alarm.h"
#include "pipeline/segment/segment.h"
#include "tests/made_images.h"

namespace beatlas::segment {
namespace {

using made::BeatingEllipsoid;

/// Blood in a wall of muscle, both beating about one centre.
struct HollowBall {
  Vec3 centre_lps = Vec3::Zero();
  double cavity_mm = 0;
  double outside_mm = 0;

  [[nodiscard]] BeatingEllipsoid cavity() const { return ball(cavity_mm, 0.25); }
  [[nodiscard]] BeatingEllipsoid body() const { return ball(outside_mm, 0.1); }

 private:
  [[nodiscard]] BeatingEllipsoid ball(double radius_mm, double squeeze) const {
    BeatingEllipsoid out;
    out.centre_lps = centre_lps;
    out.largest_mm = Vec3::Constant(radius_mm);
    out.squeeze = squeeze;
    return out;
  }
};

struct Signals {
  double blood = 400;
  double muscle = 200;
  double beyond = 20;
};

Exam exam_of(const Grid& grid, const HollowBall& heart, int phases, const Signals& signals = {}) {
  Exam out = made::ellipsoid_exam(grid, heart.body(), phases, signals.muscle, signals.beyond);
  const Exam cavity = made::ellipsoid_exam(grid, heart.cavity(), phases, 1, 0);
  for (std::size_t p = 0; p < out.stack.images.phases.size(); ++p) {
    for (std::size_t v = 0; v < grid.count(); ++v) {
      out.stack.images.phases[p][v] +=
          static_cast<float>((signals.blood - signals.muscle) * cavity.stack.images.phases[p][v]);
    }
  }
  return out;
}

/// A ball of each structure in three slices of the first phase: its ends and its middle, for beyond
/// the marks a heart goes on by no more than they lie apart.
std::vector<Seed> marks(const Grid& grid, const HollowBall& heart) {
  std::vector<Seed> out;
  const double wall_mm = heart.outside_mm - heart.cavity_mm;
  for (const double share : {-0.8, 0.0, 0.8}) {
    // In the middle of the slice next to it, whose section has these radii.
    const Vec3 at =
        grid.mm_from_index.inverse() * (heart.centre_lps + Vec3(0, 0, share * heart.cavity_mm));
    const double k = std::clamp(std::round(at[2]), 0.0, grid.size[2] - 1.0);
    const Vec3 middle(heart.centre_lps[0], heart.centre_lps[1], grid.mm(0, 0, k)[2]);
    const double off = middle[2] - heart.centre_lps[2];
    const double inner = std::sqrt(heart.cavity_mm * heart.cavity_mm - off * off);
    const double outer = std::sqrt(heart.outside_mm * heart.outside_mm - off * off);
    out.push_back({kLabelLvBlood, middle, 0.3 * inner, 0});
    out.push_back(
        {kLabelLvMyocardium, middle + Vec3(0.5 * (inner + outer), 0, 0), 0.2 * wall_mm, 0});
    out.push_back({kLabelBackground, middle + Vec3(0, outer + 8, 0), 3, 0});
    if (grid.size[2] == 1) break;
  }
  return out;
}

double dice_of(const Segmentation& result, const BeatingEllipsoid& body, bool blood, int phase) {
  const Grid& grid = result.labels.grid;
  std::vector<bool> truth;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        truth.push_back(body.contains(grid.mm(i, j, k), phase, result.labels.phase_count()));
      }
    }
  }
  const auto& labels = result.labels.phases[static_cast<std::size_t>(phase)];
  return made::dice(
      truth.size(), [&](std::size_t v) { return truth[v]; },
      [&](std::size_t v) { return blood ? labels[v] == kLabelLvBlood : labels[v] != 0; });
}

void expect_sound(const Segmentation& result) {
  for (const auto& [structure, phases] : result.coverage.phases) {
    for (const auto& phase : phases) {
      for (float c : phase) ASSERT_TRUE(c >= 0 && c <= 1) << structure_name(structure);
    }
  }
  for (const auto& phase : result.labels.phases) {
    for (std::uint8_t label : phase) ASSERT_LE(label, kLabelRestOfHeart);
  }
}

Segmentation segmented(const Exam& exam, const std::vector<Seed>& seeds) {
  StageContext context;
  return segment_exam(exam, seeds, {}, context);
}

/// Of the cavity and of the whole, in every phase.
void expect_found(const Segmentation& result, const HollowBall& heart, double blood, double whole) {
  expect_sound(result);
  const int phases = result.labels.phase_count();
  for (int p = 0; p < phases; p += std::max(1, phases / 10)) {
    EXPECT_GE(dice_of(result, heart.cavity(), true, p), blood) << p;
    EXPECT_GE(dice_of(result, heart.body(), false, p), whole) << p;
  }
}

const Grid kGrid = made::straight_grid({60, 60, 30}, {2, 2, 3});
const HollowBall kHeart{Vec3(59, 59, 43), 22, 34};

/// Voxels whose label differs, of those that are heart in either.
double differing(const Segmentation& a, const Segmentation& b) {
  double differ = 0;
  double heart = 0;
  for (std::size_t p = 0; p < a.labels.phases.size(); ++p) {
    for (std::size_t v = 0; v < a.labels.phases[p].size(); ++v) {
      const std::uint8_t one = a.labels.phases[p][v];
      const std::uint8_t other = b.labels.phases[p][v];
      heart += one != 0 || other != 0 ? 1 : 0;
      differ += one != other ? 1 : 0;
    }
  }
  return differ / heart;
}

TEST(HardImages, IntensitiesOfAnyRangeGiveTheSame) {
  const auto found = [&](const Signals& signals) {
    return segmented(exam_of(kGrid, kHeart, 4, signals), marks(kGrid, kHeart));
  };
  const Segmentation usual = found({655.35, 327.68, 0});
  expect_found(usual, kHeart, 0.82, 0.9);
  EXPECT_LT(differing(usual, found({65535, 32768, 0})), 0.002);
  EXPECT_LT(differing(usual, found({32767, 0, -32768})), 0.002) << "signed, of sixteen bits";
}

TEST(HardImages, TwoPhasesAreEnough) {
  Exam exam = exam_of(kGrid, kHeart, 2);
  made::add_rician_noise(exam.stack.images, 15, 1);
  expect_found(segmented(exam, marks(kGrid, kHeart)), kHeart, 0.88, 0.9);
}

TEST(HardImages, VoxelsTwentyTimesAsLongAsWideAreTaken) {
  const HollowBall heart{Vec3(55, 55, 60), 32, 46};
  const Grid grid = made::straight_grid({110, 110, 7}, {1, 1, 20});
  Exam exam = exam_of(grid, heart, 3);
  made::add_rician_noise(exam.stack.images, 15, 2);
  // Slices at both poles are mixed throughout: how wide the body is there cannot be told.
  expect_found(segmented(exam, marks(grid, heart)), heart, 0.83, 0.8);
}

TEST(HardImages, AHeartCutByTheFieldOfViewIsKeptInsideIt) {
  for (const Vec3& centre : {Vec3(59, 59, 12), Vec3(20, 59, 43)}) {
    const HollowBall heart{centre, 22, 34};
    Exam exam = exam_of(kGrid, heart, 4);
    made::add_rician_noise(exam.stack.images, 10, 3);
    expect_found(segmented(exam, marks(kGrid, heart)), heart, 0.87, 0.85);
  }
}

TEST(HardImages, OfTwoSeedsInOneVoxelTheLaterCounts) {
  Exam exam = exam_of(kGrid, kHeart, 3);
  made::add_rician_noise(exam.stack.images, 15, 4);
  std::vector<Seed> seeds = marks(kGrid, kHeart);
  seeds.push_back({kLabelRestOfHeart, kHeart.centre_lps, 4, -1});
  const Segmentation result = segmented(exam, seeds);
  expect_sound(result);
  const auto at = kGrid.mm_from_index.inverse() * kHeart.centre_lps;
  EXPECT_EQ(result.labels.phases[0][kGrid.offset(static_cast<int>(std::lround(at[0])),
                                                 static_cast<int>(std::lround(at[1])),
                                                 static_cast<int>(std::lround(at[2])))],
            kLabelRestOfHeart);
}

TEST(HardImages, ASingleSliceIsTaken) {
  const HollowBall heart{Vec3(59, 59, 0), 22, 34};
  const Grid grid = made::straight_grid({60, 60, 1}, {2, 2, 8});
  Exam exam = exam_of(grid, heart, 4);
  made::add_rician_noise(exam.stack.images, 15, 5);
  expect_found(segmented(exam, marks(grid, heart)), heart, 0.93, 0.9);
}

TEST(HardImages, AgainstAStillBodyAsDarkAsMuscleTheAlarmRings) {
  // The wall's lower face lies in it: no edge tells where it ends there.
  constexpr double kFace = 80;
  Exam exam = exam_of(kGrid, kHeart, 6);
  for (std::vector<float>& phase : exam.stack.images.phases) {
    for (std::size_t v = 0; v < phase.size(); ++v) {
      const auto j = static_cast<int>(v % kGrid.slice_count() / 60);
      if (kGrid.mm(0, j, 0)[1] > kFace) phase[v] = 200;
    }
  }
  made::add_rician_noise(exam.stack.images, 15, 6);
  const Segmentation result = segmented(exam, marks(kGrid, kHeart));
  expect_found(result, kHeart, 0.9, 0.75);
  StageContext context;
  const std::vector<LeakAlarm> alarms = alarm::leak_alarms(exam.stack, result, {}, context);
  const auto bare = std::find_if(alarms.begin(), alarms.end(), [](const LeakAlarm& alarm) {
    return alarm.kind == LeakKind::NoEdge;
  });
  ASSERT_NE(bare, alarms.end());
  EXPECT_GT(bare->lps_mm[1], kFace - 6);
}

TEST(HardImages, AHundredPhasesAreTaken) {
  const HollowBall heart{Vec3(50, 50, 30), 18, 27};
  const Grid grid = made::straight_grid({36, 36, 16}, {3, 3, 4});
  Exam exam = exam_of(grid, heart, 100);
  made::add_rician_noise(exam.stack.images, 15, 8);
  const Segmentation result = segmented(exam, marks(grid, heart));
  ASSERT_EQ(result.labels.phase_count(), 100);
  // Voxels of 3 x 3 x 4 mm: a quarter of the body's lie on its surface, half of the cavity's at the
  // end of systole, fifty phases from the marks.
  expect_found(result, heart, 0.65, 0.8);
}

TEST(HardImages, ConstantImagesAreRefusedThoughSeedsWereDrawn) {
  Exam exam;
  exam.stack.images = made::constant_images(kGrid, 3, 200);
  const std::string said = made::refusal([&] { (void)segmented(exam, marks(kGrid, kHeart)); });
  EXPECT_NE(said.find("no darker than blood"), std::string::npos) << said;
}

}  // namespace
}  // namespace beatlas::segment
