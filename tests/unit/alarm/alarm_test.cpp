/// Leaks made by force in a segmentation that is right: the alarm that belongs to each rings, in
/// its phase and place, and none rings without a leak.
#include "pipeline/alarm/alarm.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "pipeline/core/box.h"
#include "pipeline/core/segmented_volume.h"
#include "pipeline/edges/coverage.h"
#include "pipeline/phantom/render.h"
#include "pipeline/segment/edited_labels.h"
#include "runtime/base/error.h"

namespace beatlas::alarm {
namespace {

constexpr int kPhases = 10;
constexpr double kLiverRiseMm = 20;  // heart and liver touch
constexpr int kLeaked = 5;           // phase

/// A phantom's ventricles on a liver, and what a segmentation without error gives for them.
struct Case {
  Case() {
    phantom::PhantomSpec spec = phantom::preset("small");
    spec.anatomy = phantom::ventricles_alone(spec.anatomy);
    spec.anatomy.liver_rise_mm = kLiverRiseMm;
    spec.phases = kPhases;
    StageContext context;
    const phantom::Phantom phantom(spec);
    phantom::Rendering rendering = phantom::render(phantom, context);
    exam.stack = std::move(rendering.cine);
    right.labels = std::move(rendering.labels);
    tissue::TissueLevels levels;
    levels.blood = levels.rv_blood = phantom::kBloodCounts;
    levels.muscle = 0.34 * levels.blood;
    levels.threshold = 0.67 * levels.blood;
    levels.dark = 0.17 * levels.blood;
    right.coverage =
        edges::cover(exam.stack.images, right.labels, Box{{0, 0, 0}, exam.stack.grid().size},
                     levels, 0.05 * levels.blood)
            .coverage;
    find_ends(right);
  }
  Exam exam;
  Segmentation right;
};

const Case& made_case() {
  static const Case made;
  return made;
}

std::vector<LeakAlarm> alarms_of(const Segmentation& segmentation,
                                 const LeakOptions& options = {}) {
  StageContext context;
  return leak_alarms(made_case().exam.stack, segmentation, options, context);
}

/// The right segmentation with labels changed where `paint` says so.
Segmentation painted(
    const std::function<void(int phase, const Vec3& lps, std::uint8_t& label)>& paint) {
  Segmentation out = made_case().right;
  LabelCycle labels = out.labels;
  const Grid& grid = labels.grid;
  for (int p = 0; p < labels.phase_count(); ++p) {
    std::size_t v = 0;
    for (int k = 0; k < grid.size[2]; ++k) {
      for (int j = 0; j < grid.size[1]; ++j) {
        for (int i = 0; i < grid.size[0]; ++i, ++v) {
          paint(p, grid.mm(i, j, k), labels.phases[static_cast<std::size_t>(p)][v]);
        }
      }
    }
  }
  StageContext context;
  return segment::with_edited_labels(std::move(out), labels, context);
}

std::vector<LeakAlarm> of_kind(const std::vector<LeakAlarm>& alarms, LeakKind kind) {
  std::vector<LeakAlarm> out;
  std::copy_if(alarms.begin(), alarms.end(), std::back_inserter(out),
               [&](const LeakAlarm& alarm) { return alarm.kind == kind; });
  return out;
}

std::string told(const std::vector<LeakAlarm>& alarms) {
  std::string out;
  for (const LeakAlarm& alarm : alarms) out += alarm.sentence + "\n";
  return out;
}

/// Size 1 where it lies on the liver's surface, less inside (pipeline/phantom/thorax.cpp).
double in_liver(const Vec3& lps) {
  const Vec3 centre(-44, -5, -118 + kLiverRiseMm);
  return (lps - centre).cwiseQuotient(Vec3(62, 54, 45)).norm();
}

/// Where the heart lies nearest to the liver.
Vec3 at_the_liver() {
  const LabelCycle& labels = made_case().right.labels;
  Vec3 nearest = Vec3::Zero();
  double least = 1e9;
  std::size_t v = 0;
  for (int k = 0; k < labels.grid.size[2]; ++k) {
    for (int j = 0; j < labels.grid.size[1]; ++j) {
      for (int i = 0; i < labels.grid.size[0]; ++i, ++v) {
        if (labels.phases[kLeaked][v] == kLabelBackground) continue;
        const Vec3 lps = labels.grid.mm(i, j, k);
        if (in_liver(lps) >= least) continue;
        least = in_liver(lps);
        nearest = lps;
      }
    }
  }
  return nearest;
}

TEST(LeakAlarm, IsSilentOnARightSegmentationThatTouchesTheLiver) {
  const std::vector<LeakAlarm> alarms = alarms_of(made_case().right);
  EXPECT_TRUE(alarms.empty()) << told(alarms);
}

TEST(LeakAlarm, IsSilentAtTheBaseOfThickSlicesWhoseOutlinesFollowRules) {
  const Grid grid(made_case().right.labels.grid.part({0, 0, 0}, {40, 40, 8}));
  Grid thick = grid;
  thick.mm_from_index.linear().col(2) *= 10 / grid.spacing_mm()[2];
  Cine cine;
  cine.images.grid = thick;
  Segmentation segmentation;
  segmentation.labels.grid = thick;
  constexpr int kBase = 5;
  for (int p = 0; p < kPhases; ++p) {
    std::vector<float> image(thick.count(), 100);
    std::vector<std::uint8_t> labels(thick.count(), kLabelBackground);
    for (int k = 1; k < 8; ++k) {
      for (int j = 0; j < 40; ++j) {
        for (int i = 0; i < 40; ++i) {
          const double r = thick.spacing_mm()[0] * std::hypot(i - 20, j - 20);
          const std::size_t v = thick.offset(i, j, k);
          if (r < 25) labels[v] = k <= kBase ? kLabelLvMyocardium : kLabelRestOfHeart;
          if (r < 15) labels[v] = k <= kBase ? kLabelLvBlood : kLabelRestOfHeart;
          if (k > kBase) continue;  // nothing shows the heart there
          image[v] = r < 15 ? 1000.0F : r < 25 ? 400.0F : 100.0F;
        }
      }
    }
    cine.images.phases.push_back(std::move(image));
    segmentation.labels.phases.push_back(std::move(labels));
  }
  const auto edgeless = [&] {
    StageContext context;
    const std::vector<LeakAlarm> alarms = leak_alarms(cine, segmentation, {}, context);
    return std::any_of(alarms.begin(), alarms.end(), [](const LeakAlarm& alarm) {
      return alarm.kind == LeakKind::NoEdge && alarm.structure == Structure::Heart;
    });
  };
  EXPECT_TRUE(edgeless());
  segmentation.valve_planes[Structure::LvBlood] = {1, std::vector<double>(kPhases, kBase + 0.5)};
  EXPECT_FALSE(edgeless());
}

TEST(LeakAlarm, RingsForABlobInTheLiverInItsPhaseAndAtItsSurface) {
  const Vec3 touch = at_the_liver();
  const Vec3 down = (Vec3(-44, -5, -98) - touch).normalized();
  const Vec3 centre = touch + 10 * down;
  constexpr double kRadiusMm = 16;
  const Segmentation leaked = painted([&](int phase, const Vec3& lps, std::uint8_t& label) {
    const bool in = phase == kLeaked && (lps - centre).norm() < kRadiusMm;
    if (in && label == kLabelBackground) label = kLabelRestOfHeart;
  });
  const std::vector<LeakAlarm> alarms = alarms_of(leaked);
  const std::vector<LeakAlarm> bare = of_kind(alarms, LeakKind::NoEdge);
  ASSERT_EQ(bare.size(), 1U) << told(alarms);
  EXPECT_EQ(bare[0].structure, Structure::Heart);
  EXPECT_EQ(bare[0].phase, kLeaked);
  // The middle of a cap of the ball, in voxels of 2 x 2 x 4 mm.
  EXPECT_NEAR((bare[0].lps_mm - centre).norm(), kRadiusMm, 4);
  EXPECT_GT((bare[0].lps_mm - centre).dot(down), 0);
  EXPECT_GT(bare[0].figure, bare[0].limit);
  EXPECT_NE(bare[0].sentence.find("in phase 5 ("), std::string::npos) << bare[0].sentence;
  EXPECT_NE(bare[0].sentence.find("/segment/leak_edgeless_mm2"), std::string::npos);
}

TEST(LeakAlarm, RingsForALiverThatWasFilledToItsOwnEdge) {
  // In every phase, so that no volume jumps; the edge is sharp, but it does not beat.
  const Segmentation leaked = painted([&](int, const Vec3& lps, std::uint8_t& label) {
    if (in_liver(lps) < 1 && label == kLabelBackground) label = kLabelRestOfHeart;
  });
  const std::vector<LeakAlarm> alarms = alarms_of(leaked);
  const std::vector<LeakAlarm> still = of_kind(alarms, LeakKind::StillTissue);
  ASSERT_EQ(still.size(), 1U) << told(alarms);
  EXPECT_NEAR(in_liver(still[0].lps_mm), 1, 0.1);
  EXPECT_TRUE(of_kind(alarms, LeakKind::VolumeJump).empty()) << told(alarms);
}

TEST(LeakAlarm, RingsForACavityThatDoublesInOnePhase) {
  const Grid& grid = made_case().right.labels.grid;
  Vec3 centre = Vec3::Zero();
  double count = 0;
  for (std::size_t v = 0; v < grid.count(); ++v) {
    if (made_case().right.labels.phases[kLeaked][v] != kLabelLvBlood) continue;
    const std::size_t slice = grid.slice_count();
    const auto columns = static_cast<std::size_t>(grid.size[0]);
    centre += grid.mm(static_cast<double>(v % columns), static_cast<double>(v % slice / columns),
                      static_cast<double>(v / slice));
    ++count;
  }
  centre /= count;
  // A ball of as many voxels, clear of the cavity.
  const double radius_mm = std::cbrt(count * grid.voxel_ml() * 1e3 * 3 / (4 * M_PI));
  const Vec3 beside = centre + Vec3(0, 50, 0);
  const Segmentation leaked = painted([&](int phase, const Vec3& lps, std::uint8_t& label) {
    if (phase == kLeaked && (lps - beside).norm() < radius_mm) label = kLabelLvBlood;
  });
  const std::vector<LeakAlarm> alarms = alarms_of(leaked);
  const std::vector<LeakAlarm> jumps = of_kind(alarms, LeakKind::VolumeJump);
  const auto blood = std::find_if(jumps.begin(), jumps.end(), [](const LeakAlarm& alarm) {
    return alarm.structure == Structure::LvBlood;
  });
  ASSERT_NE(blood, jumps.end()) << told(alarms);
  EXPECT_EQ(blood->phase, kLeaked);
  EXPECT_EQ(blood->sign, 1);
  EXPECT_LT((blood->lps_mm - beside).norm(), 6) << blood->lps_mm.transpose();
  // A smaller structure's jump may fall on the phase beside: between two both look odd.
  for (const LeakAlarm& alarm : alarms) EXPECT_LE(std::abs(alarm.phase - kLeaked), 1);
}

TEST(LeakAlarm, RingsForAnOutlineThatLiesBesideTheHeartInOnePhase) {
  const LabelCycle& labels = made_case().right.labels;
  constexpr int kShiftPx = 6;  // 12 mm: a wall and more
  const Segmentation leaked = painted([&](int phase, const Vec3& lps, std::uint8_t& label) {
    if (phase != kLeaked) return;
    const Vec3 at = labels.grid.mm_from_index.inverse() * lps;
    const int i = static_cast<int>(std::lround(at[0])) - kShiftPx;
    label = i < 0
                ? static_cast<std::uint8_t>(kLabelBackground)
                : labels.phases[kLeaked][labels.grid.offset(i, static_cast<int>(std::lround(at[1])),
                                                            static_cast<int>(std::lround(at[2])))];
  });
  const std::vector<LeakAlarm> alarms = alarms_of(leaked);
  const std::vector<LeakAlarm> air = of_kind(alarms, LeakKind::Air);
  ASSERT_EQ(air.size(), 1U) << told(alarms);
  EXPECT_EQ(air[0].phase, kLeaked);
  // On the side to which it was shifted, and there in the lung.
  const Vec3 at = labels.grid.mm_from_index.inverse() * air[0].lps_mm;
  EXPECT_EQ(labels.phases[kLeaked][labels.grid.offset(static_cast<int>(std::lround(at[0])),
                                                      static_cast<int>(std::lround(at[1])),
                                                      static_cast<int>(std::lround(at[2])))],
            kLabelBackground);
}

TEST(LeakAlarm, RingsWhereLabelsReachTheBorderOfTheSlices) {
  const Grid& grid = made_case().right.labels.grid;
  const Vec3 rim = grid.mm(grid.size[0] - 1, 0.5 * grid.size[1], 0.5 * grid.size[2]);
  const Segmentation leaked = painted([&](int phase, const Vec3& lps, std::uint8_t& label) {
    if (phase == kLeaked && (lps - rim).norm() < 25) label = kLabelRestOfHeart;
  });
  const std::vector<LeakAlarm> alarms = alarms_of(leaked);
  const std::vector<LeakAlarm> border = of_kind(alarms, LeakKind::ImageBorder);
  ASSERT_EQ(border.size(), 1U) << told(alarms);
  EXPECT_EQ(border[0].phase, kLeaked);
  EXPECT_LT((border[0].lps_mm - rim).norm(), 5);
  EXPECT_NEAR(border[0].figure, M_PI * 25 * 25, 0.1 * M_PI * 25 * 25);
}

TEST(LeakAlarm, RingsForALeakThatGrowsUntilTheCycleCloses) {
  const Vec3 touch = at_the_liver();
  const Segmentation leaked = painted([&](int phase, const Vec3& lps, std::uint8_t& label) {
    const double radius_mm = 60.0 * std::cbrt(phase / (kPhases - 1.0));
    const bool in = in_liver(lps) < 1 && (lps - touch).norm() < radius_mm;
    if (in && label == kLabelBackground) label = kLabelRestOfHeart;
  });
  const std::vector<LeakAlarm> alarms = alarms_of(leaked);
  const std::vector<LeakAlarm> open = of_kind(alarms, LeakKind::OpenCycle);
  ASSERT_EQ(open.size(), 1U) << told(alarms);
  EXPECT_EQ(open[0].structure, Structure::Heart);
  EXPECT_EQ(open[0].phase, kPhases - 1);
  EXPECT_LT(in_liver(open[0].lps_mm), 1);
}

TEST(LeakAlarm, IsAnErrorOnlyWhereTheRecipeMakesItOne) {
  const Grid& grid = made_case().right.labels.grid;
  const Vec3 rim = grid.mm(0, 0.5 * grid.size[1], 0.5 * grid.size[2]);
  const std::vector<LeakAlarm> alarms =
      alarms_of(painted([&](int, const Vec3& lps, std::uint8_t& label) {
        if ((lps - rim).norm() < 20) label = kLabelRestOfHeart;
      }));
  ASSERT_FALSE(alarms.empty());
  EXPECT_NO_THROW(demand_no_leak(alarms, LeakAction::Warn));
  EXPECT_NO_THROW(demand_no_leak({}, LeakAction::Error));
  try {
    demand_no_leak(alarms, LeakAction::Error);
    FAIL() << "a leak was let through";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::Quality);
    EXPECT_NE(std::string(error.what()).find(alarms.front().sentence), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("/segment/leak"), std::string::npos);
  }
}

}  // namespace
}  // namespace beatlas::alarm
