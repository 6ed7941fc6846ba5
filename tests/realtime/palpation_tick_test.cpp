// What a tick of the palpation trainer may not do: throw, or ask the heap for memory.

#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/palpation/patch_model.h"
#include "runtime/palpation/trainer.h"
#include "tests/realtime/allocations.h"
#include "tests/unit/palpation/sample_wall.h"
#include "tests/unit/runtime_field/test_fields.h"

namespace beatlas::palpation {
namespace {

using beatlas::testing::allocations;
using beatlas::testing::counting;
using beatlas::testing::frees;

TEST(PalpationTick, CannotThrow) {
  static_assert(
      noexcept(std::declval<Trainer&>().tick(0.0, std::declval<std::span<const Finger>>())));
  static_assert(noexcept(std::declval<Circulation&>().tick(0.0, 0.0)));
  static_assert(noexcept(std::declval<VerticalPatch&>().advance(0.0, 0.0, 0.0)));
  static_assert(noexcept(std::declval<DentField&>().set({})));
}

TEST(PalpationTick, AllocatesNothingWhateverIsDoneAndWished) {
  Trainer trainer({}, 4);
  std::vector<Finger> fingers(4);
  bool finite = true;
  double largest = 0;
  allocations = 0;
  frees = 0;
  for (int n = 0; n < 20000; ++n) {
    if (n % 1000 == 500) {  // what the caller's thread does
      PalpationParameters wish;
      wish.circulation.left_atrial_mmhg = 3 + (n / 1000) % 8;
      wish.circulation.heart_rate_per_min = 60 + n / 200;
      wish.aortic_target_mmhg = n > 10000 ? 90 : 0;
      wish.segments[6].alpha = 0.5;
      trainer.wish(wish);
    }
    const double t = 1e-3 * n;
    for (int f = 0; f < 4; ++f) {
      Finger& finger = fingers[static_cast<std::size_t>(f)];
      finger = {.place_mm = Vec3(12 * f, std::sin(t), 0),
                .depth_m = 0.006 * std::sin(3 * t + f),
                .long_axis = 0.5 + 0.4 * std::sin(0.7 * t),
                .segment = 1 + (n / 50) % 17};
      if (n % 97 == f) finger.depth_m = std::nan("");
      if (n % 89 == f) finger.depth_m = 1e12;
      if (n % 83 == f) finger.long_axis = std::nan("");
      if (n % 79 == f) finger.place_mm.y() = std::nan("");
    }
    counting = true;
    const auto forces = trainer.tick(n % 101 == 0 ? std::nan("") : 1e-3, fingers);
    counting = false;
    for (const double force : forces) {
      finite = finite && std::isfinite(force);
      largest = std::max(largest, force);
    }
  }
  EXPECT_EQ(allocations, 0);
  EXPECT_EQ(frees, 0);  // what was wished before is the caller's to free
  EXPECT_TRUE(finite);
  EXPECT_GT(largest, 0.1);
}

TEST(PalpationTick, AllocatesNothingOnAnAtlassOwnMuscle) {
  const auto wall = std::make_shared<const LvWall>(test::SampleWall().wall());
  const PalpationParameters parameters = palpation_preset("anterior_infarct");
  PatchModelOptions options;
  options.parameters = parameters;
  options.muscle = std::make_shared<const AtlasMuscle>(
      wall, tissue_of_wall(*wall, parameters.segments, {}, {}), parameters);
  const auto ball = std::make_shared<const field::FieldQuery>(
      beatlas::testing::dense_payload(
          {.origin_mm = Vec3::Constant(-60), .blocks = {10, 10, 10}, .inner_mm = 14, .outer_mm = 6},
          [](const Vec3& x, double t) { return x.norm() - 34 - 2 * std::sin(8 * t); }),
      0.75);
  PatchModel model(std::make_shared<haptics::AtlasField>(ball), options);
  double largest = 0;
  bool finite = true;
  allocations = 0;
  frees = 0;
  for (int n = 0; n < 20000; ++n) {
    const double t = 1e-3 * n;
    Vec3 x = (32 + 6 * std::sin(7 * t)) * Vec3(std::cos(t), std::sin(1.3 * t), 0.3).normalized();
    if (n % 97 == 0) x *= 1e6;
    if (n % 89 == 0) x.setZero();
    counting = true;
    if (n % 1000 == 0) model.reset();
    const double force =
        model.evaluate({.position_mm = x}, {.elapsed_s = 1e-3, .field_time_s = t}).force_n.norm();
    counting = false;
    finite = finite && std::isfinite(force);
    largest = std::max(largest, force);
  }
  EXPECT_EQ(allocations, 0);
  EXPECT_EQ(frees, 0);
  EXPECT_TRUE(finite);
  EXPECT_GT(largest, 0.1);
}

}  // namespace
}  // namespace beatlas::palpation
