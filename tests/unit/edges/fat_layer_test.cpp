/// A layer of fat between muscle and lung, of profiles and of a made heart with partial volumes.
#include "pipeline/edges/fat_layer.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "pipeline/edges/layer_fit.h"
#include "tests/made_images.h"

namespace beatlas::edges::fat_layer_tests {
namespace {

constexpr double kBlood = 1000;
constexpr double kMuscle = 350;
constexpr double kFat = 1290;
constexpr double kLung = 60;
constexpr double kNoise = 50;

/// Mean over a box, in steps much finer than it.
double seen(double at_px, double edge_px, double thick_px, double width_px) {
  constexpr int kSteps = 400;
  double sum = 0;
  for (int n = 0; n < kSteps; ++n) {
    const double d = at_px + ((n + 0.5) / kSteps - 0.5) * width_px;
    sum += d < edge_px ? kMuscle : d < edge_px + thick_px ? kFat : kLung;
  }
  return sum / kSteps;
}

AcrossProfile profile(double edge_px, double thick_px) {
  AcrossProfile out;
  for (std::size_t n = 0; n < AcrossProfile::kBins; ++n) {
    out.mean[n] = seen(AcrossProfile::middle_px(n), edge_px, thick_px, 1);
    out.weight[n] = 4;
  }
  return out;
}

constexpr LayerLevels kLevels{.muscle = kMuscle, .blood = kBlood, .fat = kFat, .noise = kNoise};

TEST(FatLayerFit, FindsMusclesEdgeUnderALayerOfAnyThickness) {
  for (const double thick : {0.35, 0.7, 1.5, 3.0}) {
    for (const double edge : {-2.4, -1.1, 0.3}) {
      const auto layer = fit_fat_layer(profile(edge, thick), kLevels);
      ASSERT_TRUE(layer) << edge << " " << thick;
      EXPECT_NEAR(layer->edge_px, edge, 0.08) << thick;
      EXPECT_NEAR(layer->thickness_px, thick, 0.1) << edge;
      EXPECT_GT(layer->edge_sigma_px, 0);
      EXPECT_LT(layer->edge_sigma_px, 0.5);
    }
  }
}

TEST(FatLayerFit, MuscleBeforeLungOrFatAloneHasNoLayer) {
  EXPECT_FALSE(fit_fat_layer(profile(-0.6, 0), kLevels));
  EXPECT_FALSE(fit_fat_layer(profile(-0.6, 50), kLevels));
}

TEST(FatLayerFit, BloodBehindAWallThatIsNotSeenIsNoFat) {
  AcrossProfile atrium;
  for (std::size_t n = 0; n < AcrossProfile::kBins; ++n) {
    const double d = AcrossProfile::middle_px(n);
    atrium.mean[n] = d < -2 ? kBlood : d < 0 ? kMuscle : kLung;
    atrium.weight[n] = 4;
  }
  EXPECT_FALSE(fit_fat_layer(atrium, kLevels));
}

constexpr double kCavityMm = 14;
constexpr double kWallMm = 23.3;
constexpr double kMostFatMm = 3;

/// An upright cylinder; fat thickens from nothing on its left to kMostFatMm on its right. Labels
/// hold what is brighter than lung.
struct Made {
  Grid grid = made::straight_grid({72, 72, 3}, {1, 1, 8});
  ImageCycle<float> images = made::constant_images(grid, 2, 0);
  ImageCycle<std::uint8_t> labels;
  std::vector<float> coverage;  ///< of muscle and blood, exact but for 1 / 64

  explicit Made(double most_fat_mm) : labels{grid, {}}, coverage(grid.count()) {
    constexpr int kFine = 8;
    std::vector<float> clean(grid.count());
    for (std::size_t v = 0; v < grid.count(); ++v) {
      const auto i = static_cast<double>(v % 72);
      const auto j = static_cast<double>((v / 72) % 72);
      double sum = 0;
      for (int a = 0; a < kFine * kFine; ++a) {
        const int across = a % kFine;
        const int along = a / kFine;
        const double x = i - 35.5 + (across + 0.5) / kFine - 0.5;
        const double y = j - 35.5 + (along + 0.5) / kFine - 0.5;
        const double r = std::hypot(x, y);
        const double fat = most_fat_mm * 0.5 * (1 + x / std::max(r, 1e-9));
        sum += r < kCavityMm ? kBlood : r < kWallMm ? kMuscle : r < kWallMm + fat ? kFat : kLung;
        coverage[v] += r < kWallMm ? 1.0F / (kFine * kFine) : 0;
      }
      clean[v] = static_cast<float>(sum / (kFine * kFine));
    }
    images.phases.assign(2, clean);
    std::vector<std::uint8_t> phase(grid.count(), kLabelBackground);
    for (std::size_t v = 0; v < grid.count(); ++v) {
      const double r =
          std::hypot(static_cast<double>(v % 72) - 35.5, static_cast<double>(v / 72 % 72) - 35.5);
      if (clean[v] > 0.5 * (kMuscle + kLung)) phase[v] = kLabelLvMyocardium;
      if (r < kCavityMm) phase[v] = kLabelLvBlood;
    }
    labels.phases.assign(2, phase);
    made::add_noise(images, kNoise, 11);
  }
};

tissue::TissueLevels made_levels() {
  tissue::TissueLevels out;
  out.blood = kBlood;
  out.rv_blood = kBlood;
  out.muscle = kMuscle;
  out.threshold = 0.5 * (kBlood + kMuscle);
  out.dark = 0.5 * kMuscle;
  return out;
}

/// Nothing where there is no fat.
std::vector<std::vector<FatEdge>> stripped(Made& made, const std::vector<std::uint8_t>& stay) {
  const auto levels = levels_with_fat(made.images, kNoise, made_levels(), made.labels);
  if (!levels) return std::vector<std::vector<FatEdge>>(made.images.phases.size());
  EXPECT_NEAR(levels->fat, kFat, 100);  // much of it is mixed
  return strip_fat_layer(made.images, *levels, stay, made.labels);
}

TEST(FatLayer, ComesOffAndTellsTheEdgeBelow) {
  Made made(kMostFatMm);
  const auto before = made.labels.phases[0];
  const auto edges = stripped(made, {0, 0});
  ASSERT_EQ(edges.size(), 2U);
  ASSERT_FALSE(edges[0].empty());
  EXPECT_TRUE(std::is_sorted(edges[0].begin(), edges[0].end(),
                             [](const auto& a, const auto& b) { return a.voxel < b.voxel; }));
  double off = 0;
  double bias = 0;
  int mixed = 0;
  for (const FatEdge& edge : edges[0]) {
    const float exact = made.coverage[edge.voxel];
    if (!(exact > 0.02F && exact < 0.98F)) continue;
    off += std::abs(static_cast<double>(edge.coverage - exact));
    bias += static_cast<double>(edge.coverage - exact);
    ++mixed;
  }
  // Nearly all of three slices' circumference: 146 mm each.
  EXPECT_GT(mixed, 250);
  EXPECT_LT(off / mixed, 0.15);  // of a pixel; labels held all fat, 1.5 in the mean
  EXPECT_LT(std::abs(bias / mixed), 0.03);
  int wrong = 0;
  int was_wrong = 0;
  for (std::size_t v = 0; v < before.size(); ++v) {
    const bool inside = made.coverage[v] >= 0.5F;
    was_wrong += (before[v] != 0) != inside ? 1 : 0;
    wrong += (made.labels.phases[0][v] != 0) != inside ? 1 : 0;
  }
  EXPECT_GT(was_wrong, 500);
  EXPECT_LT(wrong, was_wrong / 6);
}

TEST(FatLayer, WithoutFatNothingChanges) {
  Made made(0);
  const auto before = made.labels.phases;
  const auto edges = stripped(made, {0, 0});
  EXPECT_TRUE(edges[0].empty());
  EXPECT_EQ(made.labels.phases, before);
}

TEST(FatLayer, KnownPhasesStay) {
  Made made(kMostFatMm);
  const auto before = made.labels.phases;
  const auto edges = stripped(made, {1, 0});
  EXPECT_TRUE(edges[0].empty());
  EXPECT_EQ(made.labels.phases[0], before[0]);
  EXPECT_NE(made.labels.phases[1], before[1]);
}

}  // namespace
}  // namespace beatlas::edges::fat_layer_tests
