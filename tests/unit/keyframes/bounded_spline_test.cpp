#include "pipeline/keyframes/bounded_spline.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "runtime/base/error.h"

namespace beatlas::keyframes {
namespace {

constexpr double kPi = std::numbers::pi;

// A ventricle of 119.9 ml that ejects, fills, rests and is filled up by its atrium.
double ventricle_ml(double share) {
  const double seconds = share - std::floor(share);  // of a beat of one second
  const std::vector<double> every_50_ms{119.9, 115, 104, 90, 77,   66, 57, 52, 50,  52,
                                        60,    72,  82,  88, 91.5, 93, 94, 95, 100, 111};
  const PeriodicSpline spline([&] {
    std::vector<double> at;
    for (std::size_t n = 0; n < every_50_ms.size(); ++n)
      at.push_back(0.05 * static_cast<double>(n));
    return at;
  }());
  const Eigen::Map<const Eigen::VectorXd> ml(every_50_ms.data(),
                                             static_cast<Eigen::Index>(every_50_ms.size()));
  return spline.weights(seconds).dot(ml);
}

// Balls of these volumes at the keys: what moves are their radii.
struct Balls {
  std::vector<double> at;
  Eigen::VectorXd ml;
  Eigen::VectorXd radius;

  Balls(std::vector<double> shares, double (*ml_of)(double))
      : at(std::move(shares)), ml(static_cast<Eigen::Index>(at.size())) {
    for (std::size_t n = 0; n < at.size(); ++n) ml[static_cast<Eigen::Index>(n)] = ml_of(at[n]);
    radius = (ml * 3 / (4 * kPi)).array().pow(1.0 / 3);
  }
  [[nodiscard]] VolumeOf volume() const {
    return [this](const Eigen::VectorXd& weights) {
      return 4 * kPi / 3 * std::pow(weights.dot(radius), 3);
    };
  }
  // How far volumes go beyond those of the two keys that they lie between [share of the largest]:
  // of all intervals, or of those that are longer or shorter than a neighbour by more than a
  // quarter.
  [[nodiscard]] double beyond(const PeriodicSpline& spline, bool uneven_alone = false) const {
    double worst = 0;
    for (std::size_t n = 0; n < at.size(); ++n) {
      const auto [low, high] = std::minmax({spline.gap((n + at.size() - 1) % at.size()),
                                            spline.gap(n), spline.gap((n + 1) % at.size())});
      if (uneven_alone && high <= 1.25 * low) continue;
      const double one = ml[static_cast<Eigen::Index>(n)];
      const double other = ml[static_cast<Eigen::Index>((n + 1) % at.size())];
      for (int part = 1; part < 100; ++part) {
        const double now = volume()(spline.weights(at[n] + spline.gap(n) * part / 100));
        worst = std::max({worst, now - std::max(one, other), std::min(one, other) - now});
      }
    }
    return worst / ml.maxCoeff();
  }
  [[nodiscard]] double largest(const PeriodicSpline& spline) const {
    double most = 0;
    for (double share = 0; share < 1; share += 0.001) {
      most = std::max(most, volume()(spline.weights(share)));
    }
    return most;
  }
};

// At 0 and 0.2 s, then every 40 ms: the atrium's last stroke is carried on into the ejection.
std::vector<double> late_keys() {
  std::vector<double> at{0};
  for (double share = 0.2; share < 0.99; share += 0.04) at.push_back(share);
  return at;
}

double rising_late_ml(double share) {
  return share > 0.9 ? 119.9 - 400 * (1 - share) : ventricle_ml(share);
}

TEST(BoundedSpline, KeepsVolumesBetweenKeysOfUnevenTimes) {
  const Balls balls(late_keys(), rising_late_ml);
  const PeriodicSpline free(balls.at);
  EXPECT_GT(balls.largest(free), 1.03 * 119.9) << "or the case is none";
  const std::vector<VolumeOf> volumes{balls.volume()};
  const BoundedSpline bounded = bounded_spline(balls.at, volumes);
  EXPECT_LT(balls.largest(bounded.spline), 1.005 * 119.9);
  EXPECT_LT(balls.beyond(bounded.spline, true), 0.005);
  EXPECT_FALSE(bounded.held.empty());
  EXPECT_LE(bounded.held.size(), 4U) << "about the long interval alone";
  for (double share = 0; share < 1; share += 0.01) {
    EXPECT_NEAR(bounded.spline.weights(share).sum(), 1, 1e-12);
  }
  for (std::size_t n = 0; n < balls.at.size(); ++n) {
    const Eigen::VectorXd weights = bounded.spline.weights(balls.at[n]);
    EXPECT_NEAR(weights[static_cast<Eigen::Index>(n)], 1, 1e-12);
    EXPECT_NEAR(weights.norm(), 1, 1e-12);
  }
}

TEST(BoundedSpline, IsSmoothInVelocityEverywhereAndBendsWithoutAJumpWhereItIsNotHeld) {
  const Balls balls(late_keys(), rising_late_ml);
  const std::vector<VolumeOf> volumes{balls.volume()};
  const BoundedSpline bounded = bounded_spline(balls.at, volumes);
  const auto radius = [&](double share) { return bounded.spline.weights(share).dot(balls.radius); };
  constexpr double kStep = 1e-4;
  for (std::size_t n = 0; n < balls.at.size(); ++n) {
    // Of a cubic, exact but for rounding.
    const auto around = [&](double side) {
      const double a = radius(balls.at[n] + side * 1e-12);
      const double b = radius(balls.at[n] + side * kStep);
      const double c = radius(balls.at[n] + side * 2 * kStep);
      const double d = radius(balls.at[n] + side * 3 * kStep);
      return std::pair(side * (-11 * a + 18 * b - 9 * c + 2 * d) / (6 * kStep),
                       (2 * a - 5 * b + 4 * c - d) / (kStep * kStep));
    };
    const auto [slope_after, bend_after] = around(1);
    const auto [slope_before, bend_before] = around(-1);
    EXPECT_NEAR(slope_after, slope_before, 1e-5) << n;
    const bool held = std::count(bounded.held.begin(), bounded.held.end(), n) != 0;
    if (held) continue;
    EXPECT_NEAR(bend_after, bend_before, 1) << n;
  }
}

// A peak that no key has is the C2 spline's, of times that differ by rounding, too.
TEST(BoundedSpline, IsTheC2SplineOfEvenTimes) {
  for (const double off : {0.0, 0.004}) {
    std::vector<double> at;
    for (int n = 0; n < 10; ++n) at.push_back(0.05 + 0.1 * n + (n % 3) * off);
    const Balls balls(at, [](double share) { return 90 + 30 * std::cos(2 * kPi * share); });
    const PeriodicSpline free(at);
    EXPECT_GT(balls.beyond(free), 0.01);
    const BoundedSpline bounded = bounded_spline(at, {balls.volume()});
    EXPECT_TRUE(bounded.held.empty());
    for (double share = 0; share < 1; share += 0.013) {
      EXPECT_EQ(bounded.spline.weights(share), free.weights(share));
    }
  }
}

// One spline for all shapes, which share walls: each is bounded, whichever beats most.
TEST(BoundedSpline, BoundsEveryShape) {
  const Balls left(late_keys(), rising_late_ml);
  const Balls heart(late_keys(), [](double share) {
    return 600 + 20 * std::cos(2 * kPi * (share - 0.03)) + 15 * std::cos(6 * kPi * share);
  });
  const BoundedSpline bounded = bounded_spline(left.at, {heart.volume(), left.volume()});
  EXPECT_LT(left.beyond(bounded.spline, true), 0.005);
  EXPECT_LT(heart.beyond(bounded.spline, true), 0.005);
}

TEST(BoundedSpline, BoundsKeysAtAnyTimes) {
  std::mt19937 random(7);
  int hard = 0;
  for (int round = 0; round < 200; ++round) {
    std::vector<double> at{0};
    const int keys = 3 + static_cast<int>(random() % 15);
    while (static_cast<int>(at.size()) < keys) {
      // From even steps to steps that differ fivefold.
      at.push_back(at.back() + 0.2 + 0.8 * (random() % 1000) / 1000.0);
    }
    const double whole = at.back() + 0.2 + 0.8 * (random() % 1000) / 1000.0;
    for (double& share : at) share /= whole;
    const Balls balls(at, ventricle_ml);
    const PeriodicSpline free(at);
    const BoundedSpline bounded = bounded_spline(at, {balls.volume()});
    hard += balls.beyond(free) > 0.005 ? 1 : 0;
    EXPECT_LT(balls.beyond(bounded.spline, true), 0.005) << round;
  }
  EXPECT_GT(hard, 50);
}

TEST(BoundedSpline, RefusesKeysThatMakeNoCycle) {
  const VolumeOf one = [](const Eigen::VectorXd&) { return 1.0; };
  EXPECT_THROW((void)bounded_spline({0, 0.5}, {one}), Error);
  EXPECT_THROW((void)bounded_spline({0.5, 0.2, 0.7}, {one}), Error);
}

}  // namespace
}  // namespace beatlas::keyframes
