// Hard cases 6 and 7: what a tool feels of the field's cells and frames. The field's own tests hold
// the same limits for distance and gradient; here they are held after the models.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "runtime/haptics/proxy.h"
#include "runtime/haptics/two_step.h"
#include "tests/unit/runtime_haptics/closed_forms.h"

namespace beatlas::haptics::stored_field_tests {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(HardCase6, MicrometreStepsOverCellFacesAreSmoothInTheForce) {
  const Vec3 axes(15, 12, 18);
  const auto field = testing::packed(
      {.origin_mm = Vec3::Constant(-24), .voxel_mm = 1, .blocks = {6, 6, 6}, .phases = 1},
      [&](const Vec3& x, double) { return testing::ellipsoid_distance(axes, x); });
  ProxyModel model(field, {});
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::uniform_int_distribution<int> axis(0, 2);
  std::uniform_real_distribution<double> depth(0.01, 2);
  double worst_step_mm = 0;
  double worst_turn_deg = 0;
  for (int n = 0; n < 100000; ++n) {
    const Vec3 direction = Vec3(normal(random), normal(random), normal(random)).normalized();
    Vec3 x = direction * (1 / direction.cwiseQuotient(axes).norm() - depth(random));
    const int a = axis(random);
    x[a] = std::round(x[a]);  // onto a face
    const Vec3 half = 0.0005 * Vec3(normal(random), normal(random), normal(random)).normalized();
    model.reset();
    const Contact before = model.evaluate(x - half, 0);
    const Contact after = model.evaluate(x + half, 0);
    if (!before.touching || !after.touching) continue;  // the face's other side lies outside
    worst_step_mm = std::max(worst_step_mm, std::abs(after.distance_mm - before.distance_mm));
    const double sine = before.normal.cross(after.normal).norm();
    worst_turn_deg = std::max(worst_turn_deg, std::asin(sine) * 180 / kPi);
  }
  EXPECT_GE(worst_step_mm, 0.95e-3);
  EXPECT_LE(worst_step_mm, 1.05e-3);
  // At 2 mm under a radius of curvature of 8 mm (12^2 / 18) 1 um turns the exact normal by
  // 1 um / 6 mm = 0.0096 deg: the case's 0.005 deg is of Discregrid's field on a 50 mm sphere,
  // where it is 0.0011 deg. So the limit is 0.005 deg beyond what the body's own curvature makes.
  EXPECT_LE(worst_turn_deg, 0.0096 + 0.005);
}

TEST(HardCase6, OnASphereOfFiftyMillimetresTheNormalKeepsTheLimitItself) {
  const auto field = testing::packed(
      {.origin_mm = Vec3(-4, -30, 34), .voxel_mm = 1, .blocks = {4, 7, 3}, .phases = 1},
      [](const Vec3& x, double) { return x.norm() - 50; });
  ProxyModel model(field, {});
  std::mt19937 random(6);
  std::uniform_real_distribution<double> u(-1, 1);
  double worst_turn_deg = 0;
  for (int n = 0; n < 100000; ++n) {
    const Vec3 direction = Vec3(0.2 + 0.1 * u(random), 0.3 * u(random), 1).normalized();
    Vec3 x = (49 + 0.9 * u(random)) * direction;
    x[n % 3] = std::round(x[n % 3]);
    const Vec3 half = 0.0005 * Vec3(u(random), u(random), u(random)).normalized();
    model.reset();
    const Contact before = model.evaluate(x - half, 0);
    const Contact after = model.evaluate(x + half, 0);
    if (!before.touching || !after.touching) continue;
    const double sine = before.normal.cross(after.normal).norm();
    worst_turn_deg = std::max(worst_turn_deg, std::asin(sine) * 180 / kPi);
  }
  EXPECT_GT(worst_turn_deg, 0.0005);
  EXPECT_LE(worst_turn_deg, 0.005);
}

TEST(HardCase7, FifteenFramesOfFiveMillimetresAreFeltToFiveMicrometres) {
  constexpr double kBeat = 0.75;
  const auto radius = [](double t) { return 25 + 5 * std::sin(2 * kPi * t / kBeat); };
  const auto payload = testing::dense_payload(
      {.origin_mm = Vec3::Constant(-39), .voxel_mm = 1.5, .blocks = {7, 7, 7}, .step_mm = 0.001},
      [&](const Vec3& x, double t) { return x.norm() - radius(t); });
  const auto query = std::make_shared<const field::FieldQuery>(payload, kBeat);
  ProxyModel proxy(std::make_shared<const AtlasField>(query), {});
  TwoStepModel published(query, {.time_mode = TimeMode::Published});
  const Vec3 direction = Vec3(2, -1, 2) / 3;
  double worst_mm = 0;
  double worst_published_mm = 0;
  for (int n = 0; n < 7500; ++n) {
    const double t = 0.001 * n;
    const Vec3 x = (radius(t) - 2) * direction;  // always 2 mm deep
    worst_mm = std::max(worst_mm, std::abs(proxy.evaluate(x, t).depth_mm - 2));
    worst_published_mm =
        std::max(worst_published_mm, std::abs(published.evaluate(x, t).depth_mm - 2));
  }
  EXPECT_LE(worst_mm, 0.005);
  EXPECT_GT(worst_published_mm, 0.09);  // linear in time: 5 mm (1 - cos(pi / 15)) = 0.11 mm
}

}  // namespace
}  // namespace beatlas::haptics::stored_field_tests
