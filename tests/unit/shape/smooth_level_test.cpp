/// Smoothing of a level beside a crease, against closed form: two balls that overlap.
#include "pipeline/shape/smooth_level.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace beatlas::shape {
namespace {

constexpr int kSize = 64;
constexpr double kEdgeMm = 1.5;
constexpr double kRadiusMm = 25;
constexpr double kApartMm = 18;  ///< of each ball's middle from the plane between them

struct Balls {
  Grid lattice{{kSize, kSize, kSize},
               Affine(Eigen::Translation3d(Vec3::Constant(-0.5 * kEdgeMm * (kSize - 1))) *
                      Eigen::Scaling(kEdgeMm))};
  std::vector<float> level;

  explicit Balls(double noise) {
    constexpr int kParts = 4;
    std::mt19937 random(5);
    std::normal_distribution<double> normal(0, 1);
    for (int k = 0; k < kSize; ++k) {
      for (int j = 0; j < kSize; ++j) {
        for (int i = 0; i < kSize; ++i) {
          int in = 0;
          for (int n = 0; n < kParts * kParts * kParts; ++n) {
            const auto part = [](int m) { return (m % kParts + 0.5) / kParts - 0.5; };
            const Vec3 x =
                lattice.mm(i + part(n), j + part(n / kParts), k + part(n / kParts / kParts));
            in += Vec3(std::abs(x[0]) - kApartMm, x[1], x[2]).norm() < kRadiusMm;
          }
          const double share = static_cast<double>(in) / (kParts * kParts * kParts);
          // Noise is where the surface is, as it is in coverage.
          const double off = in > 0 && share < 1 ? noise * normal(random) : 0;
          level.push_back(static_cast<float>(0.5 - share - off));
        }
      }
    }
  }

  [[nodiscard]] double at(const std::vector<float>& values, const Vec3& x) const {
    const Vec3 index = lattice.mm_from_index.inverse() * x;
    const Vec3 low = index.array().floor();
    double out = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 up(corner & 1, corner >> 1 & 1, corner >> 2);
      const Vec3 near = (Vec3::Ones() - up - (index - low)).cwiseAbs();
      const Vec3 c = low + up;
      out += near.prod() *
             static_cast<double>(values[lattice.offset(
                 static_cast<int>(c[0]), static_cast<int>(c[1]), static_cast<int>(c[2]))]);
    }
    return out;
  }

  /// Root mean square [mm] of where the surface lies along the ball's normal, at ways along the
  /// ball from the crease.
  [[nodiscard]] double rms_mm(const std::vector<float>& values, double from_mm,
                              double to_mm) const {
    const double crease = std::acos(-kApartMm / kRadiusMm);  // angle about a ball's middle
    double sum = 0;
    int count = 0;
    for (double way = from_mm; way <= to_mm; way += 0.5) {
      for (int turn = 0; turn < 24; ++turn) {
        const double angle = crease - way / kRadiusMm;
        const double about = 2 * std::numbers::pi * turn / 24;
        const Vec3 normal(std::cos(angle), std::sin(angle) * std::cos(about),
                          std::sin(angle) * std::sin(about));
        const Vec3 middle(kApartMm, 0, 0);
        double low = -2;
        double high = 2;
        for (int n = 0; n < 30; ++n) {
          const double here = 0.5 * (low + high);
          (at(values, middle + (kRadiusMm + here) * normal) < 0 ? low : high) = here;
        }
        sum += low * low;
        ++count;
      }
    }
    return std::sqrt(sum / count);
  }
};

std::vector<float> between_creases(const Balls& balls) {
  std::vector<float> level = balls.level;
  smooth_between_creases(level, balls.lattice, Vec3::Constant(kEdgeMm));
  return level;
}

std::vector<float> evenly(const Balls& balls) {
  std::vector<float> level = balls.level;
  smooth_evenly(level, balls.lattice,
                Vec3::Constant(kSmoothMm * kSmoothMm + kEdgeMm * kEdgeMm / 12));
  return level;
}

TEST(Smoothing, BesideAGrooveTheSurfaceStaysWithinAFewHundredthsOfAMillimetre) {
  const Balls balls(0);
  const std::vector<float> kept = between_creases(balls);
  const std::vector<float> rounded = evenly(balls);
  EXPECT_LT(balls.rms_mm(kept, 5, 9), 0.05);
  EXPECT_LT(balls.rms_mm(kept, 5, 9), 0.5 * balls.rms_mm(rounded, 5, 9));
  EXPECT_LT(balls.rms_mm(kept, 0, 4), balls.rms_mm(rounded, 0, 4));
  EXPECT_LT(balls.rms_mm(kept, 20, 50), 0.02);
}

TEST(Smoothing, ANoisyLevelIsSmoothedAsMuchAsBefore) {
  const Balls balls(0.3);
  const std::vector<float> kept = between_creases(balls);
  const std::vector<float> rounded = evenly(balls);
  EXPECT_LT(balls.rms_mm(kept, 15, 50), 1.1 * balls.rms_mm(rounded, 15, 50));
  EXPECT_LT(balls.rms_mm(kept, 0, 9), 1.05 * balls.rms_mm(rounded, 0, 9));
}

TEST(Smoothing, WhatHasNoSurfaceStays) {
  Balls balls(0);
  std::fill(balls.level.begin(), balls.level.end(), 0.5F);
  for (const float value : between_creases(balls)) ASSERT_NEAR(value, 0.5F, 1e-5F);
}

}  // namespace
}  // namespace beatlas::shape
