#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "runtime/haptics/pericardial_field.h"
#include "runtime/haptics/proxy.h"

namespace beatlas::haptics::pericardial_tests {
namespace {

constexpr double kPeriod = 0.8;
constexpr double kLargestMm = 45;
constexpr double kSwingMm = 6;
constexpr double kEffusionMm = 12;

double radius_mm(double t) {
  return kLargestMm - kSwingMm * (0.5 - 0.5 * std::cos(2 * std::numbers::pi * t / kPeriod));
}

/// A ball that beats, known to 6 mm outside as an atlas is.
class BeatingBall final : public ContactField {
 public:
  [[nodiscard]] FieldSample sample(const Vec3& x, double t) const noexcept override {
    constexpr double kOuterMm = 6;
    constexpr double kInnerMm = 10;
    FieldSample out;
    out.distance_mm = std::clamp(x.norm() - radius_mm(t), -kInnerMm, kOuterMm);
    out.in_band = std::abs(out.distance_mm) < kOuterMm - 1;
    if (out.distance_mm < kOuterMm && out.distance_mm > -kInnerMm) {
      out.gradient = x.normalized();
      const double dt = 1e-6;
      out.rate_mm_s = -(radius_mm(t + dt) - radius_mm(t - dt)) / (2 * dt);
    }
    return out;
  }
  [[nodiscard]] Vec3 outward(const Vec3& x) const noexcept override { return x.normalized(); }
  [[nodiscard]] double resolution_mm() const noexcept override { return 1.5; }
  [[nodiscard]] double reach_mm() const noexcept override { return 4.5; }
  [[nodiscard]] double period_s() const noexcept override { return kPeriod; }
};

std::shared_ptr<const PericardialField> space(const PericardialOptions& options = {
                                                  .effusion_mm = kEffusionMm}) {
  return std::make_shared<const PericardialField>(std::make_shared<BeatingBall>(),
                                                  Vec3::Constant(-kLargestMm),
                                                  Vec3::Constant(kLargestMm), options);
}

std::vector<Vec3> directions() {
  std::vector<Vec3> out;
  constexpr int kCount = 200;
  for (int n = 0; n < kCount; ++n) {  // of a spiral
    const double z = 1 - (2.0 * n + 1) / kCount;
    const double turn = 2.399963 * n;
    out.emplace_back(std::sqrt(1 - z * z) * std::cos(turn), std::sqrt(1 - z * z) * std::sin(turn),
                     z);
  }
  return out;
}

// The sac's distance and direction are the closed form's, and it stands still.
TEST(Pericardial, TheSpaceLiesBetweenTheHeartAndASacAsWideAsItWasTold) {
  const auto field = space();
  constexpr double kSacMm = kLargestMm + kEffusionMm;
  double worst_mm = 0;
  double worst_cosine = 1;
  for (const Vec3& direction : directions()) {
    for (const double inside_mm : {0.0, 1.5, 3.0, -2.0}) {
      for (const double t : {0.0, 0.21, 0.4}) {
        const FieldSample sample = field->sample((kSacMm - inside_mm) * direction, t);
        worst_mm = std::max(worst_mm, std::abs(sample.distance_mm - inside_mm));
        worst_cosine = std::min(worst_cosine, -sample.gradient.normalized().dot(direction));
        EXPECT_EQ(sample.rate_mm_s, 0);
        EXPECT_NEAR(sample.gradient.norm(), 1, 0.15);
      }
    }
    // Near the heart the space's surface is the heart's own.
    const FieldSample near = field->sample((radius_mm(0.21) + 1) * direction, 0.21);
    EXPECT_NEAR(near.distance_mm, 1, 1e-9);
    EXPECT_NE(near.rate_mm_s, 0);
  }
  EXPECT_LT(worst_mm, 0.5);
  EXPECT_GT(worst_cosine, std::cos(5 * std::numbers::pi / 180));
}

// A tip in the fluid is free; pushed to either side it is pushed back into it, by the stiffness
// times the depth, through the whole beat, and never goes through.
TEST(Pericardial, ATipIsFreeInTheFluidAndMeetsBothWalls) {
  constexpr double kTipMm = 1;
  constexpr double kStiffness = 200;
  constexpr double kSacMm = kLargestMm + kEffusionMm;
  ProxyModel model(space(), {.stiffness_n_per_m = kStiffness, .radius_mm = kTipMm});
  const Vec3 way = Vec3(1, 2, -0.5).normalized();
  double worst_mm = 0;
  for (int n = 0; n < 4000; ++n) {
    const double t = 1e-3 * n;
    // From one wall to the other and 3 mm into each, once in 2 s.
    const double middle = (kLargestMm - kSwingMm + kSacMm) / 2;
    const double swing = (kSacMm - kLargestMm + kSwingMm) / 2 + 3;
    const double r = middle + swing * std::sin(std::numbers::pi * t);
    const Contact contact =
        model.evaluate({.time_s = t, .position_mm = r * way},
                       {.elapsed_s = n == 0 ? 0 : 1e-3, .field_time_s = t, .speed = 1});
    const double into_heart = std::max(0.0, radius_mm(t) + kTipMm - r);
    const double into_sac = std::max(0.0, r - (kSacMm - kTipMm));
    const double along_n = contact.force_n.dot(way);
    const double expected_n = 1e-3 * kStiffness * (into_heart - into_sac);
    worst_mm = std::max(worst_mm, std::abs(along_n - expected_n) / (1e-3 * kStiffness));
    const double proxy = contact.proxy_mm.norm();
    EXPECT_GT(proxy, radius_mm(t) + kTipMm - 0.5) << t;
    EXPECT_LT(proxy, kSacMm - kTipMm + 0.5) << t;
  }
  EXPECT_LT(worst_mm, 0.5);
}

TEST(Pericardial, WhatMakesNoSenseIsRefused) {
  const auto heart = std::make_shared<BeatingBall>();
  const Vec3 low = Vec3::Constant(-50);
  EXPECT_THROW(PericardialField(nullptr, low, -low, {}), Error);
  EXPECT_THROW(PericardialField(heart, low, low, {}), Error);
  EXPECT_THROW(PericardialField(heart, low, Vec3::Constant(900), {}), Error);
  EXPECT_THROW(space({.effusion_mm = 0.5}), Error);
  EXPECT_THROW(space({.effusion_mm = 41}), Error);
  EXPECT_THROW(space({.effusion_mm = 10, .step_mm = 0}), Error);
}

}  // namespace
}  // namespace beatlas::haptics::pericardial_tests
