#include "runtime/palpation/patch_model.h"

#include <cmath>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "runtime/haptics/servo.h"
#include "tests/unit/palpation/plane_field.h"
#include "tests/unit/palpation/sample_wall.h"

namespace beatlas::palpation {
namespace {

constexpr double kPeriod = 0.75;

// Its surface moves by so many millimetres up and down.
class Beating final : public test::PlaneField {
 public:
  explicit Beating(double swing_mm) : PlaneField(kPeriod), swing_mm_(swing_mm) {}
  [[nodiscard]] haptics::FieldSample sample(const Vec3& x, double t) const noexcept override {
    const double w = 2 * std::numbers::pi / kPeriod;
    return above(x, swing_mm_ * std::cos(w * t), -swing_mm_ * w * std::sin(w * t));
  }

 private:
  double swing_mm_;
};

TEST(PatchModel, HeldOnAStillWallItIsAsStiffAsTableOneAndItsContraction) {
  PatchModel model(std::make_shared<Beating>(0), {});
  double least = 1e9;
  double most = 0;
  for (int n = 0; n < 8000; ++n) {
    const auto contact = model.evaluate({.position_mm = Vec3(0, 0, -5)},
                                        {.elapsed_s = n == 0 ? 0 : 1e-3, .field_time_s = 1e-3 * n});
    if (n < 5000) continue;
    EXPECT_EQ(contact.force_n.x(), 0);
    EXPECT_TRUE(contact.touching);
    least = std::min(least, contact.force_n.z());
    most = std::max(most, contact.force_n.z());
  }
  // Between rest and contraction, which the wall follows in C_v / K_c: 75 + 6 + 61 N/m full and at
  // rest, 75 + 132 + 34 contracted and empty, 75 + 6 + 34 empty and let go.
  EXPECT_GT(least, 0.005 * 115);
  EXPECT_LT(most, 0.005 * 242);
  EXPECT_GT(most, 1.2 * least);
}

TEST(PatchModel, ASofterPlaceIsFeltSofter) {
  const auto force = [](const PatchModelOptions& options) {
    PatchModel model(std::make_shared<Beating>(2), options);
    double sum = 0;
    for (int n = 0; n < 5000; ++n) {
      sum += model
                 .evaluate({.position_mm = Vec3(0, 0, -4)},
                           {.elapsed_s = 1e-3, .field_time_s = 1e-3 * n})
                 .force_n.norm();
    }
    return sum / 5000;
  };
  const double middle = force({});
  // The pressure is the same everywhere: of K_v 45 and 75 N/m, a third less, a sixth is felt.
  EXPECT_LT(force({.long_axis = 0}), 0.85 * middle);
  EXPECT_GT(force({.long_axis = 1}), 1.05 * middle);
  EXPECT_LT(force({.parameters = palpation_preset("anterior_infarct"), .segment = 7}),
            0.7 * middle);
  EXPECT_THROW(PatchModel(nullptr, {}), Error);
  EXPECT_THROW(PatchModel(std::make_shared<Beating>(0), {.long_axis = 2}), Error);
}

// As Beating, known to 6 mm outside alone, as an atlas is.
class Banded final : public test::PlaneField {
 public:
  Banded() : PlaneField(kPeriod) {}
  [[nodiscard]] haptics::FieldSample sample(const Vec3& x, double /*t*/) const noexcept override {
    constexpr double kOuterMm = 6;
    haptics::FieldSample out = above(x, 0, 0);
    if (out.distance_mm < kOuterMm) return out;
    out = {};
    out.distance_mm = kOuterMm;
    return out;
  }
  [[nodiscard]] Vec3 outward(const Vec3& /*x*/) const noexcept override {
    return Vec3(0.3, 0, 1).normalized();  // from the heart's middle, which lies askew
  }
};

// A fingertip is wider than the band that a field knows: far away it touches nothing, and as it
// comes nearer its force is that on a field which knows every distance.
TEST(PatchModel, AFingertipWiderThanTheBandTouchesWhereItIsLowest) {
  constexpr double kRadiusMm = 10;
  PatchModel banded(std::make_shared<Banded>(), {.radius_mm = kRadiusMm});
  PatchModel known(std::make_shared<Beating>(0), {.radius_mm = kRadiusMm});
  double most = 0;
  for (int n = 0; n < 3000; ++n) {
    const double above_mm = 30 - 0.01 * n;  // down to 10 mm deep
    const Vec3 x(0, 0, above_mm);
    const haptics::Moment moment{.elapsed_s = n == 0 ? 0 : 1e-3, .field_time_s = 1e-3 * n};
    const double felt = banded.evaluate({.position_mm = x}, moment).force_n.norm();
    const double expected = known.evaluate({.position_mm = x}, moment).force_n.norm();
    if (above_mm > kRadiusMm) {
      EXPECT_EQ(felt, 0) << above_mm;
    }
    EXPECT_NEAR(felt, expected, 0.02 + 0.02 * expected) << above_mm;
    most = std::max(most, felt);
  }
  EXPECT_GT(most, 0.5);
}

// The heart around test::SampleWall, standing still, with 5 mm between them.
class Ball final : public haptics::ContactField {
 public:
  static constexpr double kOutsideMm = test::kRadiusMm + 5;
  [[nodiscard]] haptics::FieldSample sample(const Vec3& x, double /*t*/) const noexcept override {
    haptics::FieldSample out;
    out.distance_mm = x.norm() - kOutsideMm;
    out.gradient = x.normalized();
    out.in_band = true;
    return out;
  }
  [[nodiscard]] Vec3 outward(const Vec3& x) const noexcept override { return x.normalized(); }
  [[nodiscard]] double resolution_mm() const noexcept override { return 1; }
  [[nodiscard]] double reach_mm() const noexcept override { return 100; }
  [[nodiscard]] double period_s() const noexcept override { return kPeriod; }
};

std::shared_ptr<const AtlasMuscle> sample_muscle(const std::string& preset) {
  auto wall = std::make_shared<const LvWall>(test::SampleWall().wall());
  const PalpationParameters parameters = palpation_preset(preset);
  TissueMap tissue = tissue_of_wall(*wall, parameters.segments, {}, {});
  return std::make_shared<const AtlasMuscle>(wall, std::move(tissue), parameters);
}

// Forces of a second and a half, each millisecond.
std::vector<double> felt_at(PatchModel& model, const Vec3& direction, double depth_mm) {
  std::vector<double> out;
  for (int n = 0; n < 1500; ++n) {
    const Vec3 x = (Ball::kOutsideMm - depth_mm) * direction.normalized();
    out.push_back(model
                      .evaluate({.position_mm = x},
                                {.elapsed_s = n == 0 ? 0 : 1e-3, .field_time_s = 1e-3 * n})
                      .force_n.norm());
  }
  return out;
}

TEST(PatchModel, TheMuscleIsThatOfThePlaceThatIsTouched) {
  const PalpationParameters parameters = palpation_preset("anterior_infarct");
  const auto muscle = sample_muscle("anterior_infarct");
  PatchModel wanders(std::make_shared<Ball>(), {.parameters = parameters, .muscle = muscle});
  // From the far side, infarct and healthy wall and back: as if it had been told each place.
  for (const Vec3& at : {Vec3(-1, -0.2, 0.1), Vec3(1, 0.1, 0.05), Vec3(0, -1, 0.1),
                         Vec3(1, 0, -0.5), Vec3(-1, 0, 0.6)}) {
    (void)felt_at(wanders, at, -3);  // in the air above it
    const WallPlace place = muscle->wall().nearest(Ball::kOutsideMm * at.normalized(), 0);
    PatchModel stays(
        std::make_shared<Ball>(),
        {.parameters = parameters, .long_axis = place.long_axis, .segment = place.segment});
    wanders.reset();
    const std::vector<double> found = felt_at(wanders, at, 4);
    const std::vector<double> expected = felt_at(stays, at, 4);
    // The wall draws back from the still ball, so the nearest vertex may become its neighbour.
    for (std::size_t n = 0; n < found.size(); n += 50) {
      EXPECT_NEAR(found[n], expected[n], 0.01 * expected[n]) << at.transpose() << " " << n;
    }
  }
}

TEST(PatchModel, AFingerThatSlidesIntoAnInfarctFeelsNoStep) {
  PatchModel model(std::make_shared<Ball>(), {.parameters = palpation_preset("anterior_infarct"),
                                              .muscle = sample_muscle("anterior_infarct")});
  double before = 0;
  double largest_step_n = 0;
  double most_n = 0;
  double last_n = 0;
  for (int n = 0; n < 8000; ++n) {
    const double angle =
        -1.6 + 2e-4 * n;  // from the lateral wall to the middle of the anterior one
    const Vec3 x = (Ball::kOutsideMm - 5) * Vec3(std::cos(angle), std::sin(angle), 0);
    last_n =
        model.evaluate({.position_mm = x}, {.elapsed_s = 1e-3, .field_time_s = 0.7}).force_n.norm();
    if (n > 1000) largest_step_n = std::max(largest_step_n, std::abs(last_n - before));
    if (n > 1000) most_n = std::max(most_n, last_n);
    before = last_n;
  }
  EXPECT_LT(last_n, 0.75 * most_n) << "it is softer there";  // under pressure: 100 to 142 N/m
  EXPECT_LT(largest_step_n, 0.049);                          // 5 gf, paper B's smallest force
}

TEST(PatchModel, OtherHeartThanTheLeftVentricleIsHealthy) {
  const auto muscle = sample_muscle("anterior_infarct");
  LvWall::Trail trail;
  const Vec3 near_mm = (test::kRadiusMm + 9) * Vec3::UnitX();
  const Vec3 far_mm = (test::kRadiusMm + 25) * Vec3::UnitX();
  PatchConstants near;
  PatchConstants far;
  for (int n = 0; n < 100; ++n) near = muscle->under(near_mm, 0, trail);
  for (int n = 0; n < 100; ++n) far = muscle->under(far_mm, 0, trail);
  EXPECT_LT(near.k_e_span_n_per_m, 0.8 * far.k_e_span_n_per_m);
  const PalpationParameters parameters = palpation_preset("anterior_infarct");
  const WallPlace place = muscle->wall().nearest(far_mm, 0);
  EXPECT_DOUBLE_EQ(far.k_v_n_per_m, parameters.at(place.long_axis, Tissue{}).k_v_n_per_m);
}

TEST(PatchModel, ABallIsFeltWithItsOwnRadius) {
  PatchModel point(std::make_shared<Ball>(), {});
  PatchModel ball(std::make_shared<Ball>(), {.radius_mm = 3});
  EXPECT_NEAR(felt_at(point, Vec3::UnitX(), 4).back(), felt_at(ball, Vec3::UnitX(), 1).back(),
              1e-12);
  EXPECT_THROW(PatchModel(std::make_shared<Ball>(), {.radius_mm = -1}), Error);
}

TEST(PatchModel, ServesAServoWhoseTicksComeOutAgainToTheBit) {
  PatchModelOptions options;
  options.parameters = palpation_preset("anterior_infarct");
  options.muscle = sample_muscle("anterior_infarct");
  haptics::Servo servo(
      {.model = std::make_unique<PatchModel>(std::make_shared<Beating>(3), options),
       .period_s = kPeriod},
      {.safety = {}, .heart = {}, .recorded_ticks = 3000});
  double largest = 0;
  for (int n = 0; n < 3000; ++n) {
    const double t = 1e-3 * n;
    const auto tick =
        servo.tick({.time_s = t, .position_mm = Vec3(0, 0, -2 - 4 * std::sin(9 * t))});
    largest = std::max(largest, tick.force_n.norm());
  }
  EXPECT_GT(largest, 0.2);
  servo.recorder().ask();
  (void)servo.tick({.time_s = 3, .position_mm = Vec3(0, 0, 5)});
  ASSERT_TRUE(servo.recorder().frozen());
  const auto replayed = haptics::replay_ticks(servo, servo.recorder().ticks());
  EXPECT_GT(replayed.ticks, 2000U);
  EXPECT_EQ(replayed.different, 0U);
}

}  // namespace
}  // namespace beatlas::palpation
