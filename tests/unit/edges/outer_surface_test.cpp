/// The heart's outside from four tissues: of profiles, and of a made heart with partial volumes.
#include "pipeline/edges/outer_surface.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <gtest/gtest.h>

#include "pipeline/edges/tissue_layers.h"
#include "runtime/atlas/structures.h"
#include "tests/made_images.h"

namespace beatlas::edges::outer_surface_tests {
namespace {

constexpr double kBlood = 1000;
constexpr double kMuscle = 350;
constexpr double kFat = 1290;
constexpr double kLung = 60;
constexpr double kNoise = 50;
constexpr LayerLevels kLevels{.muscle = kMuscle, .blood = kBlood, .fat = kFat, .noise = kNoise};
const Vec3 kSpacing(1, 1, 3);

/// What a voxel shows whose middle lies `at_mm` outside: a mean over its box, by brute force.
double seen(double at_mm, const Vec3& normal, double edge, double wall, double fat, double gain) {
  constexpr int kSteps = 6;
  constexpr int kDeep = 60;
  double sum = 0;
  for (int n = 0; n < kSteps * kSteps * kDeep; ++n) {
    const Vec3 in((n % kSteps + 0.5) / kSteps - 0.5, (n / kSteps % kSteps + 0.5) / kSteps - 0.5,
                  (n / kSteps / kSteps + 0.5) / kDeep - 0.5);
    const double d = at_mm + in.cwiseProduct(kSpacing).dot(normal) - edge;
    sum += gain * (d < -wall ? kBlood
                   : d < 0   ? kMuscle
                   : d < fat ? kFat
                             : 0) +
           (d >= fat ? kLung : 0);
  }
  return sum / (kSteps * kSteps * kDeep);
}

SurfaceProfile profile(const Vec3& normal, double edge, double wall, double fat, double gain = 1) {
  SurfaceProfile out;
  for (std::size_t n = 0; n < SurfaceProfile::kBins; ++n) {
    out.mean[n] = seen(SurfaceProfile::middle_mm(n), normal, edge, wall, fat, gain);
    out.variance[n] = 30 * 30;
  }
  return out;
}

std::size_t best(const LayersByThickness& layers) {
  return static_cast<std::size_t>(
      std::min_element(layers.at.begin(), layers.at.end(),
                       [](const auto& a, const auto& b) { return a.cost < b.cost; }) -
      layers.at.begin());
}

TEST(TissueLayers, FindTheEdgeWhicheverWayTheSurfaceLooks) {
  for (const Vec3& normal :
       {Vec3(1, 0, 0), Vec3(0, 0, -1), Vec3(0.6, 0, 0.8), Vec3(0.48, -0.64, 0.6)}) {
    for (const double wall : {0.0, 2.5, 60.0}) {
      for (const std::size_t fat : {0UL, 3UL, 6UL, 8UL}) {
        for (const double edge : {-1.4, 0.6}) {
          const auto layers = fit_layers(profile(normal, edge, wall, kFatThicknessMm[fat], 1.03),
                                         kLevels, normal, kSpacing, {0, 6});
          const LayersAt& found = layers.at[fat];
          EXPECT_NEAR(found.edge_mm, edge, 0.12)
              << normal.transpose() << ", wall " << wall << ", fat " << kFatThicknessMm[fat];
          EXPECT_LT(found.cost, layers.at[best(layers)].cost + 1);
          if (wall > 0 && wall < 6) {
            EXPECT_NEAR(found.wall_mm, wall, 0.4);
          }
          EXPECT_GT(layers.edge_sigma_mm, 0);
          EXPECT_LT(layers.edge_sigma_mm, 0.5);
        }
      }
    }
  }
}

TEST(TissueLayers, ThickFatBeforeLungIsToldFromNone) {
  const Vec3 normal(0.6, 0, 0.8);
  EXPECT_EQ(best(fit_layers(profile(normal, 0, 60, 2), kLevels, normal, kSpacing, {0, 6})), 7U);
  const auto none = fit_layers(profile(normal, 0, 60, 0), kLevels, normal, kSpacing, {0, 6});
  EXPECT_LT(none.at[0].cost + 20, none.at[7].cost);
}

constexpr double kCavityMm = 17;
constexpr double kHeartMm = 25;
constexpr double kMostFatMm = 3;
constexpr double kBaseMm = 14;     ///< above the middle a plane cuts the ball, blood and all
constexpr double kGrooveMm = 2.5;  ///< half width of a groove full of fat in the wall
const Vec3 kMiddle(32.3, 33.1, 37.4);
const Vec3 kToBase = Vec3(0.36, 0.48, 0.8);

/// A ball of muscle with blood in it, cut open at a base; fat thickens from nothing on its left to
/// kMostFatMm on its right and covers the base. Labels hold what is brighter than lung. A
/// groove on the right may be full of fat.
struct Made {
  Grid grid = made::straight_grid({66, 66, 25}, {1, 1, 3});
  ImageCycle<float> images = made::constant_images(grid, 2, 0);
  ImageCycle<std::uint8_t> labels{grid, {}};
  std::vector<float> coverage;  ///< of the heart

  /// @param labelled_mm beyond the ball labels hold nothing
  /// @param lung_mm a groove holds lung from so far above its middle on, which labels hold too
  explicit Made(bool groove = false, double fat_level = kFat, double labelled_mm = 99,
                double lung_mm = 99)
      : coverage(grid.count()) {
    constexpr int kFine = 5;
    std::vector<float> clean(grid.count());
    std::vector<std::uint8_t> phase(grid.count(), kLabelBackground);
    for (std::size_t v = 0; v < grid.count(); ++v) {
      const Vec3 at =
          kSpacing.cwiseProduct(Vec3(static_cast<double>(v % 66), static_cast<double>(v / 66 % 66),
                                     static_cast<double>(v / 66 / 66))) -
          kMiddle;
      double sum = 0;
      double share = 0;
      for (int n = 0; n < kFine * kFine * kFine; ++n) {
        const Vec3 in((n % kFine + 0.5) / kFine - 0.5, (n / kFine % kFine + 0.5) / kFine - 0.5,
                      (n / kFine / kFine + 0.5) / kFine - 0.5);
        const Vec3 x = at + in.cwiseProduct(kSpacing);
        const double r = x.norm();
        const double base = x.dot(kToBase) - kBaseMm;
        const double fat = kMostFatMm * 0.5 * (1 + x[0] / std::max(r, 1e-9));
        const bool cleft = groove && std::abs(x[1]) < kGrooveMm && x[0] > kCavityMm;
        const bool heart = r < kHeartMm && base < 0 && !cleft;
        const bool fatty = r < kHeartMm + fat && base < 2;
        share += heart ? 1 : 0;
        const bool lung = cleft && x[1] > lung_mm;
        sum += heart ? (r < kCavityMm ? kBlood : kMuscle) : fatty && !lung ? fat_level : kLung;
      }
      clean[v] = static_cast<float>(sum / (kFine * kFine * kFine));
      coverage[v] = static_cast<float>(share / (kFine * kFine * kFine));
      if (clean[v] > 0.5 * (kMuscle + kLung)) phase[v] = kLabelLvMyocardium;
      if (at[0] > 0 && at[1] > lung_mm && at[1] < kGrooveMm) phase[v] = kLabelLvMyocardium;
      if (at.norm() > kHeartMm + labelled_mm) phase[v] = kLabelBackground;
      if (phase[v] != 0 && at.norm() < kCavityMm) phase[v] = kLabelLvBlood;
    }
    images.phases.assign(2, clean);
    labels.phases.assign(2, phase);
    made::add_rician_noise(images, kNoise, 5);
  }

  [[nodiscard]] double area_mm2() const {
    const double rim = kHeartMm * kHeartMm - kBaseMm * kBaseMm;
    return std::numbers::pi * (2 * kHeartMm * (kHeartMm + kBaseMm) + rim);
  }
};

TEST(OuterSurface, IsFoundUnderFatAlongSlicesAndAtAnOpenBase) {
  Made made;
  const std::vector<std::uint8_t> before = made.labels.phases[0];
  const auto edges = fit_outer_surface(made.images, kLevels, {0, 0}, made.labels);
  ASSERT_EQ(edges.size(), 2U);
  EXPECT_TRUE(std::is_sorted(edges[0].begin(), edges[0].end(),
                             [](const auto& a, const auto& b) { return a.voxel < b.voxel; }));
  std::vector<float> found(made.grid.count());
  std::transform(made.labels.phases[0].begin(), made.labels.phases[0].end(), found.begin(),
                 [](std::uint8_t label) { return label != 0 ? 1.0F : 0.0F; });
  for (const FatEdge& edge : edges[0]) {
    found[edge.voxel] = edge.coverage;
    EXPECT_GT(edge.sigma_mm, 0);
  }
  double off = 0;
  double more = 0;
  int wrong = 0;
  int was_wrong = 0;
  for (std::size_t v = 0; v < found.size(); ++v) {
    off += std::abs(static_cast<double>(found[v] - made.coverage[v]));
    more += static_cast<double>(found[v] - made.coverage[v]);
    const bool inside = made.coverage[v] >= 0.5F;
    was_wrong += (before[v] != 0) != inside ? 1 : 0;
    wrong += (made.labels.phases[0][v] != 0) != inside ? 1 : 0;
  }
  // As a mean distance between the surfaces [mm]; labels with fat lie 1.5 mm out.
  const double to_mm = kSpacing.prod() / made.area_mm2();
  EXPECT_LT(off * to_mm, 0.25);
  EXPECT_LT(std::abs(more * to_mm), 0.08);
  EXPECT_GT(was_wrong, 3000);
  EXPECT_LT(wrong, was_wrong / 10);
}

/// Mean distance between surfaces that the difference of two coverages comes to [mm].
double mean_off_mm(const Made& made, const std::vector<FatEdge>& edges,
                   const std::vector<std::uint8_t>& labels) {
  std::vector<float> found(labels.size());
  std::transform(labels.begin(), labels.end(), found.begin(),
                 [](std::uint8_t label) { return label != 0 ? 1.0F : 0.0F; });
  for (const FatEdge& edge : edges) found[edge.voxel] = edge.coverage;
  double off = 0;
  for (std::size_t v = 0; v < found.size(); ++v) {
    off += std::abs(static_cast<double>(found[v] - made.coverage[v]));
  }
  return off * kSpacing.prod() / made.area_mm2();
}

TEST(OuterSurface, IsFoundUnderFatDullerThanBlood) {
  constexpr double kDull = 700;
  Made made(false, kDull, 0.3);
  tissue::TissueLevels known;
  known.blood = known.rv_blood = kBlood;
  known.muscle = kMuscle;
  const auto levels = levels_with_fat(made.images, kNoise, known, made.labels);
  ASSERT_TRUE(levels);
  EXPECT_NEAR(levels->fat, kDull, 150);  // much of it is mixed
  const double before = mean_off_mm(made, {}, made.labels.phases[0]);
  const auto edges = fit_outer_surface(made.images, *levels, {0, 0}, made.labels);
  EXPECT_GT(before, 0.45);
  EXPECT_LT(mean_off_mm(made, edges[0], made.labels.phases[0]), 0.35);
}

/// Voxels well within the groove, and how many of them labels hold.
std::pair<int, int> in_groove(const Made& made) {
  int groove = 0;
  int held = 0;
  for (std::size_t v = 0; v < made.grid.count(); ++v) {
    const Vec3 at =
        kSpacing.cwiseProduct(Vec3(static_cast<double>(v % 66), static_cast<double>(v / 66 % 66),
                                   static_cast<double>(v / 66 / 66))) -
        kMiddle;
    if (std::abs(at[1]) > kGrooveMm - 1 || at[0] < kCavityMm + 1.5) continue;
    if (at.norm() > kHeartMm - 1 || at.dot(kToBase) > kBaseMm - 2) continue;
    ++groove;
    held += made.labels.phases[0][v] != 0 ? 1 : 0;
  }
  return {groove, held};
}

TEST(OuterSurface, FatInAGrooveIsNoneOfTheHeart) {
  Made made(true, kFat, 0);
  (void)fit_outer_surface(made.images, kLevels, {0, 0}, made.labels);
  const auto [groove, held] = in_groove(made);
  ASSERT_GT(groove, 20);
  EXPECT_LT(held, groove / 10);
}

TEST(OuterSurface, LungBesideFatInAGrooveIsNoneOfTheHeart) {
  Made made(true, kFat, 0, 0);
  const double before = mean_off_mm(made, {}, made.labels.phases[0]);
  const auto edges = fit_outer_surface(made.images, kLevels, {0, 0}, made.labels);
  const auto [groove, held] = in_groove(made);
  ASSERT_GT(groove, 20);
  EXPECT_LT(held, groove / 3) << "fat and lung, 2.5 mm each";
  EXPECT_LT(mean_off_mm(made, edges[0], made.labels.phases[0]), 0.6 * before);
}

TEST(OuterSurface, KnownPhasesStay) {
  Made made;
  const auto before = made.labels.phases;
  const auto edges = fit_outer_surface(made.images, kLevels, {1, 0}, made.labels);
  EXPECT_TRUE(edges[0].empty());
  EXPECT_EQ(made.labels.phases[0], before[0]);
  EXPECT_NE(made.labels.phases[1], before[1]);
}

}  // namespace
}  // namespace beatlas::edges::outer_surface_tests
