#include <cmath>

#include <gtest/gtest.h>

#include "pipeline/phantom/coil_bias.h"
#include "tests/unit/phantom/scanner_images.h"

namespace beatlas::phantom {
namespace {

TEST(PhantomCoil, NoiseOfTheBackgroundIsRayleigh) {
  PhantomSpec spec = test::coarse();
  spec.scanner.snr_blood = 10.0;
  const Grid grid = spec.imaging_grid();
  const ThoraxBody skin = thorax(spec.anatomy, Signals{}).front();
  const auto images = test::images_of(spec);
  const double sigma = kBloodCounts / spec.scanner.snr_blood;
  double n = 0;
  double sum = 0;
  double squares = 0;
  for (const auto& image : images) {
    test::for_each_index(grid, [&](int i, int j, int k) {
      if (skin.surface(grid.mm(i, j, k)).distance_mm < 8.0) return;
      const double value = image[grid.offset(i, j, k)];
      ++n;
      sum += value;
      squares += value * value;
    });
  }
  ASSERT_GT(n, 50000);
  const double mean = sum / n;
  const double variance = squares / n - mean * mean;
  // Rayleigh: sigma sqrt(pi / 2), (2 - pi / 2) sigma^2; five standard errors.
  const double spread = sigma * std::sqrt(2.0 - M_PI / 2.0);
  EXPECT_NEAR(mean, sigma * std::sqrt(M_PI / 2.0), 5.0 * spread / std::sqrt(n));
  EXPECT_NEAR(variance, spread * spread, 5.0 * spread * spread * std::sqrt(2.5 / n));
}

TEST(PhantomCoil, BiasIsOneAtTheHeartAndReachesItsShareAtTheChest) {
  for (double share : {0.3, 0.9}) {
    for (int seed = 0; seed < 20; ++seed) {
      PhantomSpec spec = preset("adult");
      spec.scanner.bias_share = share;
      spec.scanner.bias_seed = seed;
      const CoilBias bias(spec);
      const Vec3 origin = spec.anatomy.origin_lps_mm;
      EXPECT_NEAR(bias.at(origin), 1.0, 1e-12);
      double low = 1e300;
      double high = -1e300;
      for (double x = -120; x <= 120; x += 10) {
        for (double y = -90; y <= 90; y += 10) {
          for (double z = -80; z <= 80; z += 20) {
            const double b = bias.at(origin + Vec3(x, y, z));
            low = std::min(low, b);
            high = std::max(high, b);
            // Smooth: no step of a millimetre changes it by more than 1/50 of its share.
            EXPECT_LT(std::abs(bias.at(origin + Vec3(x + 1, y, z)) - b), 0.03 * share);
          }
        }
      }
      EXPECT_LT(low, 1.0 - 0.7 * share);
      EXPECT_GE(low, 1.0 - share);
      EXPECT_GT(high, 1.0 + 0.7 * share);
      EXPECT_LE(high, 1.0 + share);
      EXPECT_GT(bias.at(origin + Vec3(0, -80, 0)), bias.at(origin + Vec3(0, 80, 0)));
    }
  }
}

TEST(PhantomCoil, BiasMultipliesTheImage) {
  PhantomSpec spec = test::coarse();
  const auto plain = test::images_of(spec);
  spec.scanner.bias_share = 0.5;
  const auto biased = test::images_of(spec);
  spec.scanner.bias_seed = 2;
  const auto other = test::images_of(spec);
  spec.scanner.bias_seed = 1;
  const CoilBias bias(spec);
  const Grid grid = spec.imaging_grid();
  test::for_each_index(grid, [&](int i, int j, int k) {
    const std::size_t voxel = grid.offset(i, j, k);
    // Both are rounded to a count.
    ASSERT_NEAR(biased[3][voxel], bias.at(grid.mm(i, j, k)) * plain[3][voxel], 1.3);
  });
  EXPECT_NE(biased, other);
}

TEST(PhantomCoil, SignalsAreThoseOfThePreset) {
  for (const auto& [name, myocardium, fat, liver] :
       {std::tuple{"A", 0.60, 0.75, 0.75}, std::tuple{"B", 0.34, 1.29, 0.55}}) {
    PhantomSpec spec = test::of_centres();
    spec.scanner.signals = name;
    const Signals signals = signals_preset(name);
    EXPECT_EQ(signals.myocardium, myocardium);
    EXPECT_EQ(signals.fat, fat);
    EXPECT_EQ(signals.liver, liver);
    EXPECT_EQ(signals.bone, 0.12);
    EXPECT_EQ(signals.blood, 1.0);
    const auto images = test::images_of(spec);
    for (double signal : {1.0, myocardium, fat}) {
      EXPECT_NE(std::count(images[0].begin(), images[0].end(), std::round(1000.0 * signal)), 0)
          << name << " " << signal;
    }
  }
}

}  // namespace
}  // namespace beatlas::phantom
