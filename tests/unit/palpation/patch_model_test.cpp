#include "runtime/palpation/patch_model.h"

#include <cmath>
#include <memory>
#include <numbers>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "runtime/haptics/servo.h"

namespace beatlas::palpation {
namespace {

constexpr double kPeriod = 0.75;

// A half space z < 0 whose surface moves by 3 mm.
class Beating final : public haptics::ContactField {
 public:
  explicit Beating(double swing_mm) : swing_mm_(swing_mm) {}
  [[nodiscard]] haptics::FieldSample sample(const Vec3& x, double t) const noexcept override {
    haptics::FieldSample out;
    const double w = 2 * std::numbers::pi / kPeriod;
    out.distance_mm = x.z() - swing_mm_ * std::cos(w * t);
    out.gradient = Vec3::UnitZ();
    out.rate_mm_s = swing_mm_ * w * std::sin(w * t);
    out.in_band = true;
    return out;
  }
  [[nodiscard]] Vec3 outward(const Vec3& /*x*/) const noexcept override { return Vec3::UnitZ(); }
  [[nodiscard]] double resolution_mm() const noexcept override { return 1; }
  [[nodiscard]] double reach_mm() const noexcept override { return 100; }
  [[nodiscard]] double period_s() const noexcept override { return kPeriod; }

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
  // Between rest and contraction, which the wall follows in C_v / K_c.
  EXPECT_GT(least, 0.005 * 77);
  EXPECT_LT(most, 0.005 * 134);
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
  EXPECT_LT(force({.long_axis = 0}), 0.8 * middle);
  EXPECT_GT(force({.long_axis = 1}), 1.05 * middle);
  EXPECT_LT(force({.parameters = palpation_preset("anterior_infarct"), .segment = 7}),
            0.7 * middle);
  EXPECT_THROW(PatchModel(nullptr, {}), Error);
  EXPECT_THROW(PatchModel(std::make_shared<Beating>(0), {.long_axis = 2}), Error);
}

TEST(PatchModel, ServesAServoWhoseTicksComeOutAgainToTheBit) {
  haptics::Servo servo(
      {.model = std::make_unique<PatchModel>(std::make_shared<Beating>(3), PatchModelOptions{}),
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
