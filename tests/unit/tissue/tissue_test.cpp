#include "pipeline/tissue/tissue.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "tests/made_images.h"

namespace beatlas::tissue {
namespace {

using made::BeatingEllipsoid;

TEST(Noise, OfStaticImagesIsTheKnownOne) {
  for (int phases : {2, 3, 15}) {
    auto images = made::constant_images(made::straight_grid({40, 40, 16}, {1, 1, 3}), phases, 500);
    made::add_noise(images, 20, 7);
    // A median of 25600 voxels tells a standard deviation to 0.8 % (one standard error).
    EXPECT_NEAR(temporal_stats(images).noise, 20, 20 * 0.032) << phases;
  }
}

TEST(Noise, IsNotHiddenByVoxelsThatAreZeroInEveryPhase) {
  for (int phases : {2, 15}) {
    auto images = made::constant_images(made::straight_grid({40, 40, 16}, {1, 1, 3}), phases, 500);
    made::add_noise(images, 20, 8);
    for (auto& phase : images.phases) {  // masked air: two thirds of the image
      for (std::size_t v = 0; v < phase.size(); ++v) phase[v] = v % 3 == 0 ? phase[v] : 0;
    }
    EXPECT_NEAR(temporal_stats(images).noise, 20, 20 * 0.055) << phases;  // a third of the voxels
  }
}

TEST(Noise, IsThatOfTissueWhereMostOfAMagnitudeImageIsAir) {
  for (int phases : {2, 15}) {
    auto images = made::constant_images(made::straight_grid({40, 40, 16}, {1, 1, 3}), phases, 0);
    for (auto& phase : images.phases) {
      for (std::size_t v = 0; v < phase.size(); v += 4) phase[v] = 400;
    }
    made::add_rician_noise(images, 20, 10);
    EXPECT_NEAR(temporal_stats(images).noise, 20, 20 * 0.064) << phases;  // a quarter of the voxels
  }
}

TEST(Noise, OfConstantImagesIsNone) {
  const auto images = made::constant_images(made::straight_grid({8, 8, 4}, {1, 1, 3}), 5, 500);
  const TemporalStats stats = temporal_stats(images);
  EXPECT_EQ(stats.noise, 0);
  // Sums of squares in double precision cancel to 1e-16 of 500^2.
  for (float swing : stats.swing) EXPECT_NEAR(swing, 0, 1e-4);
}

TEST(Swing, OfASineIsItsAmplitudeOverTheRootOfTwo) {
  constexpr int kPhases = 15;
  constexpr double kAmplitude = 50;
  auto images = made::constant_images(made::straight_grid({40, 40, 16}, {1.5, 1.5, 3}), kPhases, 0);
  const auto sine = [](int p) {
    return 500 + kAmplitude * std::sin(2 * std::numbers::pi * p / kPhases);
  };
  for (int p = 0; p < kPhases; ++p) {
    std::fill(images.phases[p].begin(), images.phases[p].end(), static_cast<float>(sine(p)));
  }
  const TemporalStats still = temporal_stats(images);
  // Noise takes a slow sine's second difference for its own: amplitude (1 - cos(2 pi / 15)) at
  // most. That may take 1 % off the swing.
  for (std::size_t v : {std::size_t{0}, images.grid.count() / 2}) {
    EXPECT_NEAR(still.swing[v], kAmplitude / std::numbers::sqrt2, 0.01 * kAmplitude);
    EXPECT_NEAR(still.mean[v], 500, 1e-3);
  }
  made::add_noise(images, 20, 9);
  const TemporalStats noisy = temporal_stats(images);
  double square = 0;
  for (float swing : noisy.swing)
    square += swing * swing / static_cast<double>(images.grid.count());
  // 25600 voxels average the rest of the noise out; 1 % as before.
  EXPECT_NEAR(std::sqrt(square), kAmplitude / std::numbers::sqrt2, 0.01 * kAmplitude);
}

TEST(SmoothInPlane, KeepsTheMeanAndOneSliceFromTheNext) {
  const Grid grid = made::straight_grid({31, 31, 3}, {1, 2, 5});
  std::vector<float> image(grid.count(), 0);
  image[grid.offset(15, 15, 1)] = 1;
  const std::vector<float> smooth = smooth_in_plane(grid, image, 3.0);
  double sum = 0;
  double xx = 0;
  double yy = 0;
  for (int j = 0; j < 31; ++j) {
    for (int i = 0; i < 31; ++i) {
      EXPECT_EQ(smooth[grid.offset(i, j, 0)], 0);
      EXPECT_EQ(smooth[grid.offset(i, j, 2)], 0);
      const double w = smooth[grid.offset(i, j, 1)];
      sum += w;
      xx += w * (i - 15) * (i - 15);
      yy += w * 4 * (j - 15) * (j - 15);
    }
  }
  EXPECT_NEAR(sum, 1, 1e-5);
  // 3 mm along both axes whatever the pixel; a kernel of 3 to 4 sigma loses 3 % of the variance.
  EXPECT_NEAR(std::sqrt(xx), 3, 0.05);
  EXPECT_NEAR(std::sqrt(yy), 3, 0.05);
  EXPECT_EQ(smooth_in_plane(grid, image, 0), image);
}

}  // namespace
}  // namespace beatlas::tissue
