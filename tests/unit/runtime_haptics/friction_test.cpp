#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "runtime/haptics/proxy.h"
#include "tests/unit/runtime_haptics/closed_forms.h"

namespace beatlas::haptics::friction_tests {
namespace {

using testing::FormField;
using testing::made_sample;
using Field = std::shared_ptr<const ContactField>;

constexpr double kPi = std::numbers::pi;

Field floor_below() {
  return std::make_shared<const FormField>(1.5, 1, [](const Vec3& x, double t) {
    return made_sample(x.z() - 10 * t, Vec3::UnitZ(), -10);
  });
}

Field ball(double radius_mm) {
  return std::make_shared<const FormField>(1.5, 1, [=](const Vec3& x, double) {
    return made_sample(x.norm() - radius_mm, x.normalized());
  });
}

TEST(Friction, SticksUpToTheStaticConeThenSlidesAtTheDynamicOne) {
  ProxyModel model(floor_below(), {.friction_static = 0.5, .friction_dynamic = 0.3});
  // 2 mm deep: the normal force is 0.3 N, the tool sticks within 1 mm and slides 0.6 mm behind.
  (void)model.evaluate(Vec3(0, 0, -2), 0);
  for (int n = 1; n <= 99; ++n) {
    const Vec3 force_n = model.evaluate(Vec3(0.01 * n, 0, -2), 0).force_n;
    ASSERT_LT((force_n - Vec3(-0.150 * 0.01 * n, 0, 0.3)).norm(), 1e-9) << n;
  }
  for (int n = 102; n <= 300; ++n) {
    const Vec3 force_n = model.evaluate(Vec3(0.01 * n, 0, -2), 0).force_n;
    ASSERT_LT((force_n - Vec3(-0.3 * 0.3, 0, 0.3)).norm(), 1e-9) << n;
  }
  // Held where it stopped, it sticks there; back by 0.6 mm the force along the floor is nothing.
  EXPECT_NEAR(model.evaluate(Vec3(3, 0, -2), 0).force_n.x(), -0.09, 1e-9);
  EXPECT_NEAR(model.evaluate(Vec3(2.4, 0, -2), 0).force_n.x(), 0, 1e-9);
  // Lifted, nothing is left of it.
  EXPECT_TRUE(model.evaluate(Vec3(2.4, 0, 0.5), 0).force_n.isZero());
  EXPECT_NEAR(model.evaluate(Vec3(2, 0, -1), 0).force_n.x(), 0, 1e-12);
}

TEST(Friction, AFloorThatRisesCarriesTheStuckPointAlong) {
  ProxyModel model(floor_below(), {.friction_static = 0.5, .friction_dynamic = 0.5});
  (void)model.evaluate(Vec3(0, 0, -2), 0);
  for (int n = 1; n <= 100; ++n) {
    const double t = 0.001 * n;
    const Vec3 force_n = model.evaluate(Vec3(0.5, 0, -2), t).force_n;
    ASSERT_LT((force_n - 0.150 * Vec3(-0.5, 0, 2 + 10 * t)).norm(), 1e-9);
  }
}

TEST(Friction, OnABallTheForceStaysWithinTheCone) {
  for (double radius_mm : {0.0, 3.0}) {
    ProxyModel model(ball(20),
                     {.radius_mm = radius_mm, .friction_static = 0.4, .friction_dynamic = 0.4});
    // Round the ball at 100 mm/s, 2 mm deep: the tool drags 0.8 mm behind.
    const double r = 18 + radius_mm;
    for (int n = 0; n < 2000; ++n) {
      const double angle = 0.1 / r * n;
      const Vec3 out(std::cos(angle), std::sin(angle), 0);
      const Vec3 ahead(-std::sin(angle), std::cos(angle), 0);
      const Vec3 force_n = model.evaluate(r * out, 0).force_n;
      ASSERT_NEAR(force_n.dot(out), 0.3, 1e-3);
      ASSERT_LE(-force_n.dot(ahead), 0.4 * 0.3 + 1e-3);
      if (n > 20) {
        ASSERT_NEAR(-force_n.dot(ahead), 0.4 * 0.3, 0.01) << n;
      }
      ASSERT_NEAR(force_n.z(), 0, 1e-9);
    }
  }
}

TEST(Friction, AClosedPathOfTheToolNeverGainsEnergy) {
  ProxyModel model(ball(20), {.friction_static = 0.6, .friction_dynamic = 0.3});
  std::mt19937 random(8);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int path = 0; path < 200; ++path) {
    // A loop of random size and depth under the surface, walked twice; begins and ends outside.
    model.reset();
    const double a = 3 * u(random);
    const double b = 3 * u(random);
    const double depth = 1.5 + u(random);
    double gained_mj = 0;
    Vec3 last = Vec3(0, 0, 21);
    Vec3 force = Vec3::Zero();
    const int steps = 4000;
    for (int n = 0; n <= steps; ++n) {
      const double s = static_cast<double>(n) / steps;
      const double lift = 20.5 - (depth + 0.5) * std::min(1.0, 8 * std::sin(kPi * s));
      const Vec3 x =
          lift *
          Vec3(a * std::sin(4 * kPi * s) / 20, b * std::sin(8 * kPi * s) / 20, 1).normalized();
      const Vec3 now = model.evaluate(x, 0).force_n;
      gained_mj += 0.5 * (force + now).dot(x - last);  // trapezoid
      force = now;
      last = x;
    }
    EXPECT_LE(gained_mj, 1e-3) << path;
  }
}

TEST(Friction, GoesOnToTheBitFromItsMemory) {
  const ProxyOptions options{.radius_mm = 1, .friction_static = 0.5, .friction_dynamic = 0.2};
  ProxyModel one(ball(20), options);
  ProxyModel other(ball(20), options);
  std::mt19937 random(4);
  std::normal_distribution<double> step(0, 0.3);
  Vec3 x(18, 3, 2);
  for (int n = 0; n < 2000; ++n) {
    x += Vec3(step(random), step(random), step(random)) + 0.02 * (Vec3(17, 0, 0) - x);
    other.restore(one.memory());
    ASSERT_EQ(one.evaluate(x, 0.001 * n, 0.001).force_n,
              other.evaluate(x, 0.001 * n, 0.001).force_n);
    ASSERT_EQ(one.memory(), other.memory());
  }
}

TEST(Friction, RefusesCoefficientsOutOfRange) {
  EXPECT_THROW(ProxyModel(ball(20), {.friction_static = 1.1}), Error);
  EXPECT_THROW(ProxyModel(ball(20), {.friction_static = 0.2, .friction_dynamic = 0.3}), Error);
  EXPECT_THROW(ProxyModel(ball(20), {.friction_static = std::nan("")}), Error);
}

}  // namespace
}  // namespace beatlas::haptics::friction_tests
