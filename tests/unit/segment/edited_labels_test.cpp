#include "pipeline/segment/edited_labels.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "pipeline/core/segmented_volume.h"
#include "pipeline/segment/segment.h"
#include "runtime/base/error.h"

namespace beatlas::segment {
namespace {

constexpr int kPhases = 2;
constexpr double kOuterPx = 14.0;
constexpr double kInnerPx = 8.0;

/// A ring of muscle around blood in slices 2..5 of 8, 1.5 x 1.5 x 8 mm; coverage in closed form
/// (distance to the circle) on a part of the grid.
Segmentation made() {
  Segmentation out;
  out.labels.grid.size = {64, 60, 8};
  out.labels.grid.mm_from_index.linear() = Vec3(1.5, 1.5, 8).asDiagonal();
  out.labels.phases.assign(kPhases, std::vector<std::uint8_t>(out.labels.grid.count(), 0));
  out.coverage.first = {8, 6, 1};
  out.coverage.grid = out.labels.grid.part(out.coverage.first, {46, 46, 6});
  for (const Structure structure : kVentricular) {
    if (structure == Structure::RvBlood) continue;
    out.coverage.phases[structure].assign(kPhases,
                                          std::vector<float>(out.coverage.grid.count(), 0.0F));
  }
  const auto inside = [](double r, double radius) {
    return static_cast<float>(std::clamp(radius - r + 0.5, 0.0, 1.0));
  };
  for (int p = 0; p < kPhases; ++p) {
    for (int k = 2; k <= 5; ++k) {
      for (int j = 0; j < 60; ++j) {
        for (int i = 0; i < 64; ++i) {
          const double r = std::hypot(i - 30, j - 28);
          auto& label =
              out.labels.phases[static_cast<std::size_t>(p)][out.labels.grid.offset(i, j, k)];
          label = r < kInnerPx ? kLabelLvBlood : r < kOuterPx ? kLabelLvMyocardium : 0;
          const Index3 at{i - 8, j - 6, k - 1};
          if (!out.coverage.grid.contains(at[0], at[1], at[2])) continue;
          const std::size_t v = out.coverage.grid.offset(at[0], at[1], at[2]);
          const auto phase = static_cast<std::size_t>(p);
          const float blood = inside(r, kInnerPx);
          out.coverage.phases[Structure::LvBlood][phase][v] = blood;
          out.coverage.phases[Structure::Heart][phase][v] = inside(r, kOuterPx);
          out.coverage.phases[Structure::LvMyocardium][phase][v] = inside(r, kOuterPx) - blood;
        }
      }
    }
  }
  return out;
}

/// A smoothed outline lies inside the circle by sigma^2 / 2R, so it holds pi sigma^2 pixels less,
/// whatever its radius; sigma is one pixel. Pixel corners leave up to four either way.
constexpr double kSmoothedPx = std::numbers::pi;
constexpr double kPixelsOff = 4;

/// Paints a disc of one label into one slice of one phase; gives the number of its pixels.
double paint(LabelCycle& labels, int phase, int k, double x, double y, double radius,
             std::uint8_t label) {
  double count = 0;
  for (int j = 0; j < labels.grid.size[1]; ++j) {
    for (int i = 0; i < labels.grid.size[0]; ++i) {
      if (std::hypot(i - x, j - y) >= radius) continue;
      labels.phases[static_cast<std::size_t>(phase)][labels.grid.offset(i, j, k)] = label;
      ++count;
    }
  }
  return count;
}

double volume_ml(const Segmentation& segmentation, Structure structure, std::size_t phase) {
  return segmented_volume_ml(segmentation, structure)[phase];
}

int last_slice(const LabelCycle& labels, std::size_t phase, std::uint8_t label) {
  const auto found = std::find(labels.phases[phase].rbegin(), labels.phases[phase].rend(), label);
  const auto behind = static_cast<std::size_t>(found - labels.phases[phase].rbegin());
  return static_cast<int>((labels.grid.count() - behind - 1) / labels.grid.slice_count());
}

TEST(EditedLabels, WithoutAChangeAllStays) {
  const Segmentation before = made();
  StageContext context;
  const Segmentation after = with_edited_labels(before, before.labels, context);
  EXPECT_EQ(after.coverage.first, before.coverage.first);
  for (const auto& [structure, phases] : before.coverage.phases) {
    EXPECT_EQ(after.coverage.phases.at(structure), phases);
  }
  EXPECT_EQ(after.coverage.phases.count(Structure::RvBlood), 0U);
  EXPECT_TRUE(after.warnings.empty());
}

TEST(EditedLabels, APaintedDiscAddsItsVolumeAndOnlyNearItAnythingChanges) {
  const Segmentation before = made();
  LabelCycle labels = before.labels;
  const double disc = paint(labels, 1, 3, 48, 45, 5, kLabelRestOfHeart) - kSmoothedPx;
  StageContext context;
  const Segmentation after = with_edited_labels(before, labels, context);
  const double added =
      volume_ml(after, Structure::Heart, 1) - volume_ml(before, Structure::Heart, 1);
  const double voxel_ml = before.labels.grid.voxel_ml();
  EXPECT_NEAR(added / voxel_ml, disc, kPixelsOff);
  EXPECT_EQ(volume_ml(after, Structure::Heart, 0), volume_ml(before, Structure::Heart, 0));
  EXPECT_EQ(volume_ml(after, Structure::LvBlood, 1), volume_ml(before, Structure::LvBlood, 1));
  ASSERT_EQ(after.warnings.size(), 1U);
  EXPECT_NE(after.warnings.front().find("in 1 phase)"), std::string::npos)
      << after.warnings.front();
}

TEST(EditedLabels, BloodPaintedIntoTheWallIsTakenFromTheWall) {
  const Segmentation before = made();
  LabelCycle labels = before.labels;
  const double disc = paint(labels, 0, 4, 30, 28, 11, kLabelLvBlood) - kSmoothedPx;
  StageContext context;
  const Segmentation after = with_edited_labels(before, labels, context);
  const double voxel_ml = before.labels.grid.voxel_ml();
  const double more = disc - std::numbers::pi * kInnerPx * kInnerPx;
  const auto gained_px = [&](Structure structure) {
    return (volume_ml(after, structure, 0) - volume_ml(before, structure, 0)) / voxel_ml;
  };
  EXPECT_NEAR(gained_px(Structure::LvBlood), more, kPixelsOff);
  EXPECT_NEAR(gained_px(Structure::LvMyocardium), -more, kPixelsOff);
  EXPECT_NEAR(volume_ml(after, Structure::Heart, 0), volume_ml(before, Structure::Heart, 0),
              0.002 * volume_ml(before, Structure::Heart, 0));
  EXPECT_EQ(after.end_diastole, 0) << "the phase whose cavity was enlarged";
  for (std::size_t v = 0; v < after.coverage.grid.count(); ++v) {
    EXPECT_LE(after.coverage.phases.at(Structure::LvBlood)[0][v] +
                  after.coverage.phases.at(Structure::LvMyocardium)[0][v],
              1.0001F);
  }
}

TEST(EditedLabels, PaintOutsideThePartThatHadCoverageCounts) {
  const Segmentation before = made();
  LabelCycle labels = before.labels;
  double disc = 0;
  for (int p = 0; p < kPhases; ++p) {
    disc = paint(labels, p, 7, 58, 30, 5, kLabelRvBlood) - kSmoothedPx;
  }
  StageContext context;
  const Segmentation after = with_edited_labels(before, labels, context);
  EXPECT_NEAR(volume_ml(after, Structure::RvBlood, 0) / before.labels.grid.voxel_ml(), disc,
              kPixelsOff);
  EXPECT_NEAR(volume_ml(after, Structure::LvBlood, 0), volume_ml(before, Structure::LvBlood, 0),
              1e-9);
}

TEST(EditedLabels, TheBasesPlaneFollowsWhatIsTakenAwayBeforeIt) {
  Segmentation before = made();
  const int base = last_slice(before.labels, 1, kLabelLvBlood);
  before.valve_planes[Structure::LvBlood] = {1, {base + 0.3, base + 0.3}};
  LabelCycle painted = before.labels;
  for (std::size_t v = 0; v < painted.grid.slice_count(); ++v) {
    auto& label = painted.phases[1][painted.grid.offset(0, 0, base) + v];
    if (label == kLabelLvBlood) label = kLabelRestOfHeart;
  }
  StageContext context;
  const Segmentation after = with_edited_labels(before, painted, context);
  EXPECT_EQ(after.valve_planes.at(Structure::LvBlood).k,
            (std::vector<double>{base + 0.3, base - 0.5}));
}

TEST(EditedLabels, TheBasesPlaneFollowsPaintBeyondIt) {
  Segmentation before = made();
  // The LV ends at 3.2: slices 4 and 5 show a pool that is labelled rest of the heart.
  before.valve_planes[Structure::LvBlood] = {1, {3.2, 3.2}};
  LabelCycle& labels = before.labels;
  for (auto& phase : labels.phases) {
    for (int k = 4; k <= 5; ++k) {
      for (std::size_t v = 0; v < labels.grid.slice_count(); ++v) {
        auto& label = phase[labels.grid.offset(0, 0, k) + v];
        if (label == kLabelLvBlood) label = kLabelRestOfHeart;
      }
    }
  }
  const Grid& part = before.coverage.grid;
  for (auto& phase : before.coverage.phases[Structure::LvBlood]) {
    std::fill(phase.begin() + static_cast<std::ptrdiff_t>(part.offset(0, 0, 3)), phase.end(), 0.0F);
  }
  LabelCycle painted = labels;
  const double disc = paint(painted, 1, 4, 30, 28, 5, kLabelLvBlood) - kSmoothedPx;
  StageContext context;
  const Segmentation after = with_edited_labels(before, painted, context);
  EXPECT_EQ(after.valve_planes.at(Structure::LvBlood).k, (std::vector<double>{3.2, 4.5}));
  // In that slice the paint counts, and nothing of the pool around it.
  double in_slice = 0;
  const Grid& grid = after.coverage.grid;
  for (std::size_t v = 0; v < grid.slice_count(); ++v) {
    in_slice += after.coverage.phases.at(
        Structure::LvBlood)[1][grid.offset(0, 0, 4 - after.coverage.first[2]) + v];
  }
  EXPECT_NEAR(in_slice, disc, kPixelsOff);
}

TEST(EditedLabels, WhatCannotBeatIsRefused) {
  const Segmentation before = made();
  StageContext context;
  const auto refusal = [&](const LabelCycle& labels) -> std::string {
    try {
      (void)with_edited_labels(before, labels, context);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
      return error.what();
    }
    return {};
  };
  LabelCycle labels = before.labels;
  labels.phases[0][0] = 8;
  EXPECT_NE(refusal(labels).find("value 8 in phase 0"), std::string::npos);
  labels = before.labels;
  paint(labels, 1, 3, 50, 30, 6, kLabelRvBlood);
  EXPECT_NE(refusal(labels).find("rv_blood"), std::string::npos);
  labels = before.labels;
  for (auto& phase : labels.phases) phase.assign(phase.size(), 0);
  EXPECT_NE(refusal(labels).find("no heart"), std::string::npos);
  labels.phases.pop_back();
  EXPECT_FALSE(refusal(labels).empty());
}

}  // namespace
}  // namespace beatlas::segment
