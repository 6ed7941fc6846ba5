#include "pipeline/edges/magnitude.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace beatlas::edges {
namespace {

/// Mean of |signal + complex noise| by integrating over both channels.
double mean_by_integration(double signal, double noise) {
  constexpr int kSteps = 400;
  constexpr double kReach = 6;
  double mean = 0;
  for (int a = 0; a < kSteps; ++a) {
    for (int b = 0; b < kSteps; ++b) {
      const double u = kReach * (2 * (a + 0.5) / kSteps - 1);
      const double v = kReach * (2 * (b + 0.5) / kSteps - 1);
      mean += std::exp(-0.5 * (u * u + v * v)) * std::hypot(signal + noise * u, noise * v);
    }
  }
  const double area = 4 * kReach * kReach / (kSteps * kSteps);
  return mean * area / (2 * std::numbers::pi);
}

TEST(Magnitude, IsThatOfNoiseInTwoChannels) {
  for (const double signal : {0.0, 20.0, 40.0, 75.0, 150.0, 340.0, 1000.0}) {
    EXPECT_NEAR(mean_magnitude(static_cast<float>(signal), 50), mean_by_integration(signal, 50),
                0.01 * 50)
        << signal;
  }
}

TEST(Magnitude, OfASignalTellsTheSignal) {
  for (const float signal : {25.0F, 40.0F, 75.0F, 340.0F, 1000.0F}) {
    EXPECT_NEAR(signal_of(mean_magnitude(signal, 50), 50), signal, 2.5) << signal;
  }
  EXPECT_EQ(signal_of(10, 50), 0) << "less than noise alone";
}

TEST(Magnitude, WithoutNoiseIsTheSignal) {
  EXPECT_EQ(mean_magnitude(7, 0), 7);
  EXPECT_EQ(signal_of(7, 0), 7);
  EXPECT_NEAR(Mixture(340, 40, 0).missing(0.3F), 0, 1e-6);
}

TEST(Magnitude, OfMuscleAndLungInAVoxelIsBelowTheLineBetweenThem) {
  constexpr double kNoise = 50;
  const double lung = mean_by_integration(40, kNoise);
  const double muscle = mean_by_integration(340, kNoise);
  const Mixture mixture(static_cast<float>(muscle), static_cast<float>(lung), kNoise);
  for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    const double seen = mean_by_integration(share * 340 + (1 - share) * 40, kNoise);
    EXPECT_NEAR(mixture.missing(static_cast<float>(share)), share - (seen - lung) / (muscle - lung),
                0.005)
        << share;
  }
  EXPECT_GT(mixture.missing(0.5F), 0.03F);
}

}  // namespace
}  // namespace beatlas::edges
