#include "runtime/haptics/proxy.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "tests/unit/runtime_haptics/closed_forms.h"

namespace beatlas::haptics::proxy_tests {
namespace {

using testing::FormField;
using testing::made_sample;
using Field = std::shared_ptr<const ContactField>;

constexpr double kTick = 0.001;

// z < 0 is solid.
Field floor_below() {
  return std::make_shared<const FormField>(
      1.5, 1, [](const Vec3& x, double) { return made_sample(x.z(), Vec3::UnitZ()); });
}

Field ball(double radius_mm, double known_mm = 1e3) {
  return std::make_shared<const FormField>(1.5, 1, [=](const Vec3& x, double) {
    const double distance = x.norm() - radius_mm;
    if (distance < -known_mm) return made_sample(-known_mm, Vec3::Zero());
    return made_sample(distance, x.norm() > 0 ? Vec3(x.normalized()) : Vec3(Vec3::UnitX()));
  });
}

TEST(Proxy, OutOfContactThereIsDistanceAndNoForce) {
  ProxyModel model(ball(20), {.radius_mm = 2});
  for (double r : {40.0, 22.01, 35.0}) {
    const Contact contact = model.evaluate(Vec3(0, r, 0), 0);
    EXPECT_FALSE(contact.touching);
    EXPECT_TRUE(contact.force_n.isZero());
    EXPECT_NEAR(contact.distance_mm, r - 22, 1e-12);
    EXPECT_NEAR(contact.normal.y(), 1, 1e-12);
    EXPECT_EQ(contact.proxy_mm, Vec3(0, r, 0));
  }
}

TEST(Proxy, AToolThatStartsInsideIsLedOutTheNearestWay) {
  for (double known_mm : {1e3, 5.0}) {  // also from where the field knows no direction
    ProxyModel model(ball(20, known_mm), {.radius_mm = 2});
    const Vec3 x = 8 * Vec3(2, -1, 2) / 3;
    const Contact contact = model.evaluate(x, 0);
    EXPECT_TRUE(contact.touching);
    EXPECT_LT((contact.force_n - 0.150 * 14 * x / 8).norm(), 1e-3);
    // The damper has seen no movement yet.
    ProxyModel damped(ball(20, known_mm), {.radius_mm = 2, .damping_n_s_per_m = 5});
    EXPECT_EQ(damped.evaluate(x, 0, 0.001).force_n, contact.force_n);
  }
}

TEST(Proxy, AToolThatComesFromFarAwayIsFeltAtOnce) {
  const auto field = testing::packed(
      {.origin_mm = Vec3::Constant(-36), .voxel_mm = 1.5, .blocks = {6, 6, 6}, .outer_mm = 4},
      [](const Vec3& x, double) { return x.norm() - 20; });
  const Vec3 inside = 12 * Vec3(2, -1, 2) / 3;
  ProxyModel at_start(field, {.radius_mm = 2});
  const Contact wished = at_start.evaluate(inside, 0);
  ASSERT_NEAR(wished.depth_mm, 10, 0.05);
  for (const double far_mm : {130.0, 1e5, 1e9, 1e150, 1e308}) {
    for (const Vec3& from : {Vec3(far_mm, 0, 0), Vec3(0, -far_mm, far_mm)}) {
      ProxyModel model(field, {.radius_mm = 2});
      // As it starts, and after a contact; then it stays, as a device that was not calibrated does.
      for (int again = 0; again < 2; ++again) {
        for (int n = 0; n < 20; ++n) {
          const Contact away = model.evaluate(from, 0);
          EXPECT_FALSE(away.touching) << far_mm;
          EXPECT_TRUE(away.force_n.isZero()) << far_mm;
        }
        const Contact contact = model.evaluate(inside, 0);
        EXPECT_TRUE(contact.touching) << far_mm;
        EXPECT_EQ(contact.force_n, wished.force_n) << far_mm;
      }
    }
  }
}

TEST(Proxy, ADeviceThatLeavesThroughTheSideIsLetGoAtOnce) {
  ProxyModel model(floor_below(), {.stiffness_n_per_m = 1000});
  for (int n = 0; n < 50; ++n) (void)model.evaluate(Vec3(0.1 * n, 0, -2), 0);
  EXPECT_NEAR(model.evaluate(Vec3(5, 0, -2), 0).force_n.z(), 2, 1e-9);
  const Contact away = model.evaluate(Vec3(5, 3, 1), 0);
  EXPECT_FALSE(away.touching);
  EXPECT_TRUE(away.force_n.isZero());
}

TEST(Proxy, NothingDragsAQuickTool) {
  // 5 m/s along the floor: the force stays normal to it.
  ProxyModel model(floor_below(), {});
  for (int n = 0; n < 100; ++n) {
    const Contact contact = model.evaluate(Vec3(5.0 * n, 0, -1), 0);
    ASSERT_LT((contact.force_n - Vec3(0, 0, 0.150)).norm(), 1e-12);
  }
}

class Gradual final : public StiffnessMap {
 public:
  [[nodiscard]] double n_per_m(const Vec3& surface_mm, double t) const noexcept override {
    return 100 + 10 * surface_mm.x() + t;
  }
};

TEST(Proxy, AMapGivesTheStiffnessAtTheContactPoint) {
  ProxyModel model(floor_below(), {.radius_mm = 3, .map = std::make_shared<Gradual>()});
  EXPECT_NEAR(model.evaluate(Vec3(4, 0, 1), 5).force_n.z(), 0.145 * 2, 1e-9);
  // Beyond what a model may be, the map is cut.
  model.reset();
  EXPECT_NEAR(model.evaluate(Vec3(-40, 0, 1), 5).force_n.z(), 0.001 * 2, 1e-9);
}

// The standard linear solid pressed at a constant speed v from the touch on:
// F = K v t + C v (1 - exp(-k t / C)).
TEST(Proxy, DampingIsThatOfAStandardLinearSolid) {
  constexpr double kSpeed = 40;  // mm/s
  constexpr double kDamping = 3;
  ProxyModel model(floor_below(), {.damping_n_s_per_m = kDamping});
  (void)model.evaluate(Vec3(0, 0, 0), 0, 0);
  for (int n = 1; n < 100; ++n) {
    const double t = kTick * n;
    const double force = model.evaluate(Vec3(0, 0, -kSpeed * t), t, kTick).force_n.z();
    const double exact =
        1e-3 * (150 * kSpeed * t + kDamping * kSpeed * (1 - std::exp(-500 * t / kDamping)));
    ASSERT_NEAR(force, exact, 1e-9);
  }
  // Held still, the static force is left.
  double force = 0;
  for (int n = 100; n < 200; ++n) force = model.evaluate(Vec3(0, 0, -4), 0, kTick).force_n.z();
  EXPECT_NEAR(force, 0.6, 1e-6);
}

TEST(Proxy, DampingNeitherPullsNorChattersOnAnEncodersSteps) {
  constexpr double kStepMm = 0.055;
  ProxyModel model(floor_below(), {.damping_n_s_per_m = 5});
  std::mt19937 random(3);
  std::uniform_real_distribution<double> noise(-0.5, 0.5);
  double last = 0;
  double chatter = 0;
  for (int n = 0; n < 20000; ++n) {
    // A hand that goes slowly in and out, seen through the encoder, dithering between two counts.
    const double z = -2 + 2.2 * std::cos(0.0005 * n) + 0.5 * kStepMm * noise(random);
    const double seen = kStepMm * std::round(z / kStepMm);
    const Contact contact = model.evaluate(Vec3(0, 0, seen), 0, kTick);
    ASSERT_GE(contact.force_n.z(), 0);
    chatter = std::max(chatter, std::abs(contact.force_n.z() - last));
    last = contact.force_n.z();
  }
  // A step is felt as (K + k) D = 0.036 N, beside what the damper gives back in a tick; a velocity
  // from differences would give C D / T = 0.275 N. The limit is paper B's smallest force.
  EXPECT_LE(chatter, 0.049);
}

TEST(Proxy, GoesOnToTheBitFromItsMemory) {
  const Field field = ball(20);
  ProxyModel one(field, {.radius_mm = 1, .damping_n_s_per_m = 2});
  ProxyModel other(field, {.radius_mm = 1, .damping_n_s_per_m = 2});
  std::mt19937 random(4);
  std::normal_distribution<double> step(0, 0.3);
  Vec3 x(18, 3, 2);
  for (int n = 0; n < 2000; ++n) {
    x += Vec3(step(random), step(random), step(random)) + 0.02 * (Vec3(17, 0, 0) - x);
    other.restore(one.memory());
    const Contact a = one.evaluate(x, kTick * n, kTick);
    const Contact b = other.evaluate(x, kTick * n, kTick);
    ASSERT_EQ(a.force_n, b.force_n);
    ASSERT_EQ(a.proxy_mm, b.proxy_mm);
    ASSERT_EQ(one.memory(), other.memory());
  }
}

TEST(Proxy, RefusesOptionsOutOfRange) {
  EXPECT_THROW(ProxyModel(nullptr, {}), Error);
  for (double bad : {-1.0, std::nan(""), 1e9}) {
    EXPECT_THROW(ProxyModel(ball(20), {.stiffness_n_per_m = bad}), Error);
    EXPECT_THROW(ProxyModel(ball(20), {.radius_mm = bad}), Error);
    EXPECT_THROW(ProxyModel(ball(20), {.damping_n_s_per_m = bad}), Error);
    EXPECT_THROW(ProxyModel(ball(20), {.damper_spring_n_per_m = bad}), Error);
  }
}

}  // namespace
}  // namespace beatlas::haptics::proxy_tests
