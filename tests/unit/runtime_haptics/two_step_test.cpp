#include "runtime/haptics/two_step.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "runtime/haptics/servo.h"
#include "tests/unit/runtime_field/test_fields.h"

namespace beatlas::haptics::two_step_tests {
namespace {

constexpr double kPeriod = 0.8;

double radius(double t) { return 18 + 2 * std::sin(2 * std::numbers::pi * t / kPeriod); }

// A sphere about the origin that beats by 2 mm, known 12 mm deep.
std::shared_ptr<const field::FieldQuery> sphere() {
  static const auto query = std::make_shared<const field::FieldQuery>(
      beatlas::testing::dense_payload({.origin_mm = Vec3::Constant(-27.9),
                                       .blocks = {5, 5, 5},
                                       .phases = 16,
                                       .rr_interval_s = kPeriod,
                                       .inner_mm = 12,
                                       .outer_mm = 6},
                                      [](const Vec3& x, double t) { return x.norm() - radius(t); }),
      kPeriod);
  return query;
}

Vec3 random_direction(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Vec3(normal(random), normal(random), normal(random)).normalized();
}

TEST(TwoStep, ForceIsProportionalToTheDepthAlongTheOutwardNormal) {
  TwoStepModel model(sphere(), {.stiffness_n_per_m = 200});
  std::mt19937 random(1);
  std::uniform_real_distribution<double> depth(-4, 9);
  std::uniform_real_distribution<double> time(-5, 5);
  for (int n = 0; n < 2000; ++n) {
    const double t = time(random);
    const Vec3 direction = random_direction(random);
    const double d = depth(random);
    const Contact contact = model.evaluate((radius(t) - d) * direction, t);
    // 0.005 mm of the field at 200 N/m, and 0.2 degrees on up to 1.8 N.
    EXPECT_NEAR(contact.force_n.norm(), 0.2 * std::max(0.0, d), 0.001);
    EXPECT_LT((contact.force_n - 0.2 * std::max(0.0, d) * direction).norm(), 0.001 + 0.0035 * 1.8);
    if (std::abs(d) > 0.01) {
      EXPECT_EQ(contact.touching, d > 0);
    }
    EXPECT_NEAR(contact.distance_mm, -d, 0.005);
    if (d > 0.01) {
      EXPECT_LT((contact.proxy_mm - radius(t) * direction).norm(), 0.05);
    }
    const double velocity =
        2 * 2 * std::numbers::pi / kPeriod * std::cos(2 * std::numbers::pi * t / kPeriod);
    EXPECT_NEAR(contact.surface_velocity_mm_s, velocity, 0.16);  // 1 % of 15.7 mm/s
  }
}

TEST(TwoStep, AHeldHeartDoesNotMove) {
  TwoStepModel model(sphere(), {.held_time_s = 0.2});  // largest
  const Vec3 x(0, 0, 16);
  for (double t : {0.0, 0.1, 0.6, 77.7}) {
    const Contact contact = model.evaluate(x, t);
    EXPECT_NEAR(contact.force_n.z(), 0.150 * 4, 0.001);
    EXPECT_EQ(contact.surface_velocity_mm_s, 0);
  }
}

TEST(TwoStep, ABeatingSurfaceLosesNoTickOfAStillUser) {
  // Hard case 2 on this sphere: the user 2.5 mm inside the mean surface, which moves by 2 mm.
  TwoStepModel model(sphere(), {});
  const Vec3 x = 15.5 * Vec3(1, 2, -2) / 3;
  double largest_error = 0;
  for (int n = 0; n < 4000; ++n) {
    const double t = 0.001 * n;
    const Contact contact = model.evaluate(x, t);
    ASSERT_TRUE(contact.touching) << t;
    const double expected = 0.150 * (radius(t) - 15.5);
    largest_error = std::max(largest_error, (contact.force_n - expected * x.normalized()).norm());
  }
  EXPECT_LE(largest_error, 0.009);  // CHAI3D on a rigid mesh
}

TEST(TwoStep, PublishedModeIsLinearBetweenTheForcesAtStoredFrames) {
  TwoStepModel published(sphere(), {.time_mode = TimeMode::Published});
  TwoStepModel continuous(sphere(), {});
  const double frame = kPeriod / 16;
  std::mt19937 random(2);
  std::uniform_real_distribution<double> u(0, 1);
  for (int n = 0; n < 500; ++n) {
    const Vec3 x = (13 + 6 * u(random)) * random_direction(random);
    const double k = std::floor(32 * u(random)) - 16;
    const double share = u(random);
    const Vec3 a = continuous.evaluate(x, k * frame).force_n;
    const Vec3 b = continuous.evaluate(x, (k + 1) * frame).force_n;
    const Contact found = published.evaluate(x, (k + share) * frame);
    EXPECT_LT((found.force_n - ((1 - share) * a + share * b)).norm(), 1e-5);
    EXPECT_NEAR(found.depth_mm, found.force_n.norm() / 0.150, 1e-9);
  }
  // Halfway between frames a chord lies below the arc of a sine: by 1 - cos(pi / 16) of 2 mm at
  // the crest. The modes differ there by what physiology.md, section 5, calls paper A's error.
  const double crest = kPeriod / 4 + 0.5 * frame;  // frame 4 is the crest; between 4 and 5
  const Vec3 x(15, 0, 0);
  const double arc = continuous.evaluate(x, crest).force_n.x();
  const double chord = published.evaluate(x, crest).force_n.x();
  const double expected = 0.150 * (radius(crest) - 0.5 * (radius(4 * frame) + radius(5 * frame)));
  EXPECT_NEAR(arc - chord, expected, 2e-4);
  EXPECT_GT(expected, 0.002);
}

TEST(TwoStep, BelowTheKnownDepthTheDirectionOfTheContactStays) {
  TwoStepModel model(sphere(), {.held_time_s = 0.0});
  // Push in along z, then on past the known 12 mm and past the centre to the other side.
  Vec3 last = Vec3::Zero();
  for (double z = 19; z > -4; z -= 0.05) {
    const Contact contact = model.evaluate(Vec3(0.3, 0, z), 0);
    if (!contact.touching) continue;
    EXPECT_GT(contact.normal.z(), 0.99) << z;
    EXPECT_LE(contact.depth_mm, 12);
    if (z < 17) {
      EXPECT_LT((contact.force_n - last).norm(), 0.150 * 0.05 * 1.1 + 0.01) << z;
    }
    last = contact.force_n;
  }
  // A start inside, with nothing to remember: away from the centre.
  model.reset();
  const Contact start = model.evaluate(Vec3(0.3, 0, -4), 0);
  EXPECT_LT(start.normal.z(), -0.98);
}

TEST(TwoStep, RefusesOptionsOutOfRange) {
  EXPECT_THROW(TwoStepModel(nullptr, {}), Error);
  EXPECT_THROW(TwoStepModel(sphere(), {.stiffness_n_per_m = 0}), Error);
  EXPECT_THROW(TwoStepModel(sphere(), {.stiffness_n_per_m = std::nan("")}), Error);
  EXPECT_THROW(TwoStepModel(sphere(), {.held_time_s = std::nan("")}), Error);
}

TEST(Servo, BadStatesGiveZeroForceAndARampAfterwards) {
  Servo servo(two_step_scene(sphere(), {}), {});
  const Vec3 inside(0, 0, 14);
  double t = 0;
  const auto next = [&](const Vec3& x, bool valid) {
    t += 0.001;
    return servo.tick({.time_s = t, .position_mm = x, .valid = valid});
  };
  for (int n = 0; n < 1000; ++n) (void)next(inside, true);
  EXPECT_GT(next(inside, true).force_n.z(), 0.2);
  for (const Vec3& bad : {Vec3(std::nan(""), 0, 0), Vec3(0, INFINITY, 0)}) {
    const Tick fault = next(bad, true);
    EXPECT_EQ(fault.status, TickStatus::Fault);
    EXPECT_TRUE(fault.force_n.isZero());
    EXPECT_LT(next(inside, true).force_n.norm(), 0.01);
    for (int n = 0; n < 1000; ++n) (void)next(inside, true);
  }
  const Tick unplugged = next(inside, false);
  EXPECT_EQ(unplugged.status, TickStatus::Fault);
  EXPECT_TRUE(unplugged.force_n.isZero());
  servo.stop();
  EXPECT_EQ(next(inside, true).status, TickStatus::Fault);
  servo.restart();
  EXPECT_NE(next(inside, true).status, TickStatus::Fault);
}

}  // namespace
}  // namespace beatlas::haptics::two_step_tests
