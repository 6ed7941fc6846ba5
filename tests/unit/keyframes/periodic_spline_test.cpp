#include "pipeline/keyframes/periodic_spline.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "runtime/base/error.h"

namespace beatlas::keyframes::periodic_spline_tests {
namespace {

constexpr double kPi = std::numbers::pi;
const std::vector<double> kUneven{0.05, 0.2, 0.27, 0.5, 0.7, 0.8};

TEST(PeriodicSpline, GoesThroughItsKeysAndKeepsWhatIsConstant) {
  const PeriodicSpline spline(kUneven);
  for (std::size_t n = 0; n < kUneven.size(); ++n) {
    const Eigen::VectorXd weights = spline.weights(kUneven[n] + 3);
    for (Eigen::Index m = 0; m < weights.size(); ++m) {
      EXPECT_NEAR(weights[m], m == static_cast<Eigen::Index>(n) ? 1 : 0, 1e-12);
    }
  }
  for (double share = -0.5; share < 1.5; share += 0.013) {
    EXPECT_NEAR(spline.weights(share).sum(), 1, 1e-12);
  }
}

// From both sides of every key, the wrap among them: the same value, slope and bend.
TEST(PeriodicSpline, BendsWithoutAJump) {
  const PeriodicSpline spline(kUneven);
  constexpr double kStep = 1e-3;
  const auto around = [&](double share, double side) {
    const Eigen::VectorXd a = spline.weights(share + side * 1e-9);
    const Eigen::VectorXd b = spline.weights(share + side * kStep);
    const Eigen::VectorXd c = spline.weights(share + side * 2 * kStep);
    const Eigen::VectorXd d = spline.weights(share + side * 3 * kStep);
    const Eigen::VectorXd slope = side * (-11 * a + 18 * b - 9 * c + 2 * d) / (6 * kStep);
    const Eigen::VectorXd bend = (2 * a - 5 * b + 4 * c - d) / (kStep * kStep);
    return std::pair(slope, bend);
  };
  for (const double key : kUneven) {
    const auto [slope_after, bend_after] = around(key, 1);
    const auto [slope_before, bend_before] = around(key, -1);
    EXPECT_LT((slope_after - slope_before).norm(), 1e-4 * slope_after.norm());
    EXPECT_LT((bend_after - bend_before).norm(), 1e-2 * bend_after.norm());
  }
}

// Cubic splines err by h^4: half the distance of keys, a sixteenth of the error.
TEST(PeriodicSpline, ErrsWithTheFourthPowerOfTheKeysDistance) {
  const auto error = [](int keys) {
    std::vector<double> at;
    Eigen::VectorXd values(keys);
    for (int n = 0; n < keys; ++n) {
      at.push_back(static_cast<double>(n) / keys);
      values[n] = std::sin(2 * kPi * at.back() + 0.4);
    }
    const PeriodicSpline spline(at);
    double worst = 0;
    for (double share = 0; share < 1; share += 0.001) {
      worst = std::max(
          worst, std::abs(spline.weights(share).dot(values) - std::sin(2 * kPi * share + 0.4)));
    }
    return worst;
  };
  EXPECT_NEAR(error(10) / error(20), 16, 2);
}

TEST(ThereAndBack, IsThePapersFiveKeysInEightAndThirteenPhases) {
  const ThereAndBack both = there_and_back(5, 8.0 / 21);
  EXPECT_EQ(both.key, (std::vector<int>{0, 1, 2, 3, 4, 3, 2, 1}));
  for (std::size_t n = 0; n < 5; ++n) {
    EXPECT_NEAR(21 * both.at[n], 2.0 * static_cast<double>(n), 1e-12);
  }
  for (std::size_t n = 5; n < 8; ++n) {
    EXPECT_NEAR(21 * both.at[n], 8 + 13 * (static_cast<double>(n) - 4) / 4, 1e-12);
  }
}

TEST(PeriodicSpline, RefusesKeysThatMakeNoCycle) {
  EXPECT_THROW(PeriodicSpline({0, 0.5}), Error);
  EXPECT_THROW(PeriodicSpline({0, 0.5, 0.5}), Error);
  EXPECT_THROW(PeriodicSpline({0, 0.5, 1}), Error);
  EXPECT_THROW(PeriodicSpline({-0.1, 0.5, 0.9}), Error);
  EXPECT_THROW((void)there_and_back(1, 0.5), Error);
  EXPECT_THROW((void)there_and_back(5, 1), Error);
}

}  // namespace
}  // namespace beatlas::keyframes::periodic_spline_tests
