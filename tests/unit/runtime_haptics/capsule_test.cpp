#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "runtime/haptics/capsule_axis.h"
#include "runtime/haptics/proxy.h"
#include "tests/unit/runtime_haptics/closed_forms.h"

namespace beatlas::haptics {
namespace {

using testing::FormField;
using testing::made_sample;
using Field = std::shared_ptr<const ContactField>;

constexpr double kPi = std::numbers::pi;
constexpr double kK = 150;
constexpr double kPerMm = kK * 1e-3;  // N/mm
constexpr double kBeat = 0.75;
// The proxy ends when what is left is at most 1 um.
constexpr double kSettledN = kPerMm * 1e-3;

Field floor_below() {
  return std::make_shared<const FormField>(
      1.5, 1, [](const Vec3& x, double) { return made_sample(x.z(), Vec3::UnitZ()); });
}

double beating(double t) { return 25 + 5 * std::sin(2 * kPi * t / kBeat); }

Field ball() {
  return std::make_shared<const FormField>(1.5, kBeat, [](const Vec3& x, double t) {
    const double r = x.norm();
    const double speed = 5 * 2 * kPi / kBeat * std::cos(2 * kPi * t / kBeat);
    return made_sample(r - beating(t), r > 0 ? Vec3(x / r) : Vec3::UnitX(), -speed);
  });
}

Vec3 nearest_of_axis(const CapsuleAxis& axis, const Vec3& to) {
  const double share =
      std::clamp((to - axis.middle_mm).dot(axis.half_mm) / axis.half_mm.squaredNorm(), -1.0, 1.0);
  return axis.at(share);
}

ServoState state_of(const CapsuleAxis& axis, double t = 0) {
  return {.time_s = t,
          .position_mm = axis.middle_mm,
          .orientation = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), axis.half_mm)};
}

TEST(CapsuleAxis, TheNearestPlaceIsThatOfTheClosedForm) {
  const Field field = ball();
  std::mt19937 random(1);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int n = 0; n < 2000; ++n) {
    const CapsuleAxis axis{40 * Vec3(u(random), u(random), u(random)),
                           30 * Vec3(u(random), u(random), u(random))};
    const double exact = nearest_of_axis(axis, Vec3::Zero()).norm() - beating(0.1);
    const NearestOnAxis found = nearest_on_axis(*field, axis, 0.1, 1.2);
    EXPECT_NEAR(found.sample.distance_mm, exact, 1e-4);
    EXPECT_GE(found.sample.distance_mm, exact - 1e-9);
    EXPECT_NEAR(found.sample.distance_mm, field->sample(axis.at(found.share), 0.1).distance_mm,
                1e-12);
  }
}

// Two balls beside the axis: two places where it is nearest, and the lower one is wanted.
TEST(CapsuleAxis, OfSeveralLowPlacesTheLowestIsFound) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int n = 0; n < 500; ++n) {
    const Vec3 a(-15 + 3 * u(random), 4 + u(random), 0);
    const Vec3 b(12 + 3 * u(random), 4 + u(random), 0);
    const FormField field(1, 1, [&](const Vec3& x, double) {
      const Vec3 from = (x - a).norm() < (x - b).norm() ? x - a : x - b;
      return made_sample(from.norm() - 3, from.normalized());
    });
    const CapsuleAxis axis{Vec3::Zero(), Vec3(20, 0, 0)};
    const double exact = std::min(a.tail<2>().norm(), b.tail<2>().norm()) - 3;
    // The other place may be taken where it looks lower: sampled half a step from the lowest place
    // of a ball, 3 mm or more away, the distance is at most (0.5 mm)^2 / (2 * 3 mm) larger.
    const double found = nearest_on_axis(field, axis, 0, 1.2).sample.distance_mm;
    EXPECT_GE(found, exact - 1e-9);
    EXPECT_LE(found, exact + 0.042);
  }
}

// Half a capsule's axis leaves the floor at an angle: its lower end is what touches.
TEST(Capsule, OnAFloorForceAndTorqueAreClosedForms) {
  constexpr double kRadius = 3;
  constexpr double kHalf = 20;
  for (const double tilt : {0.0, 0.02, 0.1, 0.5, 1.2, kPi / 2}) {
    for (const double depth : {0.5, 2.0, 5.0}) {
      ProxyModel model(floor_below(), {.radius_mm = kRadius, .half_length_mm = kHalf});
      const Vec3 along(std::cos(tilt), 0, std::sin(tilt));
      const double rise = kHalf * std::sin(tilt);
      CapsuleAxis axis{Vec3(7, -4, kRadius + rise + 1), kHalf * along};
      EXPECT_FALSE(model.evaluate(state_of(axis), {}).touching);
      axis.middle_mm.z() = kRadius + rise - depth;
      const Contact contact = model.evaluate(state_of(axis), {});
      EXPECT_TRUE(contact.touching);
      EXPECT_NEAR(contact.depth_mm, depth, 1e-3);
      EXPECT_LT((contact.force_n - Vec3(0, 0, kPerMm * depth)).norm(), kSettledN);
      // The bed is pressed in by depth - (s + half) sin(tilt) from the lower end on: its middle.
      const double slope = std::sin(tilt);
      const double length = slope > 0 ? std::min(depth / slope, 2 * kHalf) : 2 * kHalf;
      const double low = depth - slope * length;  // at the far end of what is pressed
      const double centre = length * (depth / 6 + low / 3) / (0.5 * (depth + low));
      const Vec3 lever = (centre - kHalf) * along - Vec3(0, 0, kRadius);
      const Vec3 torque = lever.cross(Vec3(0, 0, kPerMm * depth));
      EXPECT_LT((contact.torque_n_mm - torque).norm(), 2e-3 * kHalf * kPerMm * depth + 1e-3)
          << tilt << " " << depth;
    }
  }
}

// What holds the middle off a ball is the ball drawn along the axis: a larger capsule.
TEST(Capsule, OnABallTheForceIsThatOfACapsuleOfBothRadii) {
  const Field field = ball();
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int n = 0; n < 300; ++n) {
    ProxyModel model(field, {.radius_mm = 3, .half_length_mm = 15});
    const Vec3 out = Vec3(normal(random), normal(random), normal(random)).normalized();
    CapsuleAxis axis{60 * out,
                     15 * Vec3(normal(random), normal(random), normal(random)).normalized()};
    for (int step = 0; step < 400; ++step) {
      const double gap = nearest_of_axis(axis, Vec3::Zero()).norm() - (beating(0) + 3);
      if (gap < -4) break;
      const Contact contact = model.evaluate(state_of(axis), {});
      const Vec3 push = nearest_of_axis(axis, Vec3::Zero()).normalized();
      const Vec3 exact = kPerMm * std::max(0.0, -gap) * push;
      EXPECT_LT((contact.force_n - exact).norm(), 2 * kSettledN) << n << " at " << gap;
      axis.middle_mm -= 0.1 * out;
    }
  }
}

// Its ends on the two walls of a right-angled groove: each wall is further in by half its length.
TEST(Capsule, AcrossAGrooveBothWallsHoldIt) {
  const Vec3 left = Vec3(1, 0, 1).normalized();
  const Vec3 right = Vec3(-1, 0, 1).normalized();
  const Field groove = std::make_shared<const FormField>(1.5, 1, [&](const Vec3& x, double) {
    return left.dot(x) < right.dot(x) ? made_sample(left.dot(x), left)
                                      : made_sample(right.dot(x), right);
  });
  for (const double tilt : {0.0, 0.1, -0.3}) {
    const CapsuleAxis shape{Vec3::Zero(), 10 * Vec3(std::cos(tilt), 0, std::sin(tilt))};
    ProxyModel model(groove, {.radius_mm = 2, .half_length_mm = 10});
    const double on_left = 2 + std::abs(left.dot(shape.half_mm));
    const double on_right = 2 + std::abs(right.dot(shape.half_mm));
    const Vec3 corner = on_left * left + on_right * right;  // the walls are at right angles
    for (double deep = -1; deep < 4; deep += 0.02) {
      const CapsuleAxis axis{corner - Vec3(0, 0, deep), shape.half_mm};
      const Contact contact = model.evaluate(state_of(axis), {});
      const Vec3 exact = deep > 0 ? Vec3(0, 0, kPerMm * deep) : Vec3::Zero();
      EXPECT_LT((contact.force_n - exact).norm(), 4 * kSettledN) << tilt << " " << deep;
    }
  }
}

TEST(Capsule, AStillOneLosesNoTickOfABeatingAtlasAndFeelsTheClosedForm) {
  const Field field = testing::packed(
      {.origin_mm = Vec3::Constant(-48), .blocks = {8, 8, 8}, .rr_interval_s = kBeat},
      [](const Vec3& x, double t) { return x.norm() - beating(t); });
  ProxyModel model(field, {.radius_mm = 3, .half_length_mm = 15});
  const Vec3 out = Vec3(1, 2, -2).normalized();
  const CapsuleAxis axis{20 * out + Vec3(0, 0, 3), 15 * out.unitOrthogonal()};
  int touching = 0;
  double worst_n = 0;
  double step_n = 0;
  Vec3 before = Vec3::Zero();
  const auto ticks = static_cast<int>(2 * kBeat * 1000);
  for (int n = 0; n < ticks; ++n) {
    const double t = 0.001 * n;
    const Contact contact =
        model.evaluate(state_of(axis, t), {.elapsed_s = 0.001, .field_time_s = t});
    const Vec3 near = nearest_of_axis(axis, Vec3::Zero());
    const double depth = beating(t) + 3 - near.norm();
    ASSERT_GT(depth, 0.5);
    touching += contact.touching ? 1 : 0;
    worst_n = std::max(worst_n, (contact.force_n - kPerMm * depth * near.normalized()).norm());
    if (n > 0) step_n = std::max(step_n, (contact.force_n - before).norm());
    before = contact.force_n;
  }
  EXPECT_EQ(touching, ticks);
  EXPECT_LE(worst_n, 0.009);                                               // hard case 2
  EXPECT_LE(step_n, kPerMm * 5 * 2 * kPi / kBeat * 1e-3 + 2 * kSettledN);  // the wall's own speed
}

TEST(Capsule, OfNoLengthIsASphereToTheBit) {
  ProxyModel sphere(ball(), {.radius_mm = 3, .friction_static = 0.3, .friction_dynamic = 0.2});
  ProxyModel capsule(
      ball(),
      {.radius_mm = 3, .half_length_mm = 0, .friction_static = 0.3, .friction_dynamic = 0.2});
  for (int n = 0; n < 2000; ++n) {
    const double t = 0.001 * n;
    const Vec3 x = 27 * Vec3(std::sin(t), std::cos(t), 0.2 * std::sin(3 * t));
    const Moment moment{.elapsed_s = 0.001, .field_time_s = t};
    const Eigen::Quaterniond turned(Eigen::AngleAxisd(t, Vec3::UnitX()));
    const Contact a = sphere.evaluate({.time_s = t, .position_mm = x}, moment);
    const Contact b =
        capsule.evaluate({.time_s = t, .position_mm = x, .orientation = turned}, moment);
    ASSERT_EQ(a.force_n, b.force_n);
    ASSERT_TRUE(b.torque_n_mm.isZero());
  }
}

// Sideways and lengthwise through a wall 3 mm thick, at up to 1 m/s.
TEST(Capsule, IsNotPushedThroughAThinWall) {
  const Field wall = std::make_shared<const FormField>(2, 1, [](const Vec3& x, double) {
    const double side = x.z() >= 0 ? 1 : -1;
    return made_sample(std::abs(x.z()) - 1.5, side * Vec3::UnitZ());
  });
  std::mt19937 random(4);
  std::uniform_real_distribution<double> u(0, 1);
  int through = 0;
  for (int n = 0; n < 2000; ++n) {
    ProxyModel model(wall, {.radius_mm = u(random), .half_length_mm = 20 * u(random)});
    const double tilt = 0.5 * kPi * u(random);
    const Vec3 along(std::cos(tilt), 0, std::sin(tilt));
    const double step_mm = 0.1 + 0.9 * u(random);
    for (Vec3 x(0, 0, 25); x.z() > -25; x.z() -= step_mm) {
      const Contact contact = model.evaluate(state_of({x, along}), {});
      if (contact.proxy_mm.z() < 0) ++through;
    }
  }
  EXPECT_EQ(through, 0);
}

TEST(Capsule, RefusesALengthOutOfRange) {
  EXPECT_THROW(ProxyModel(ball(), {.half_length_mm = -1}), Error);
  EXPECT_THROW(ProxyModel(ball(), {.half_length_mm = 101}), Error);
}

}  // namespace
}  // namespace beatlas::haptics
