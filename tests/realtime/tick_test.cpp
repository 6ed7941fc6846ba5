// What a servo tick may not do: throw, or ask the heap for memory.

#include <atomic>
#include <cmath>
#include <numbers>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/device/simulated.h"
#include "runtime/haptics/proxy.h"
#include "runtime/haptics/servo.h"
#include "runtime/haptics/shell.h"
#include "runtime/haptics/taxels.h"
#include "runtime/haptics/watchdog.h"
#include "tests/realtime/allocations.h"
#include "tests/unit/runtime_field/test_fields.h"

using beatlas::testing::allocations;
using beatlas::testing::counting;
using beatlas::testing::frees;

namespace beatlas {
namespace {

constexpr double kPeriod = 0.75;

std::shared_ptr<const field::FieldQuery> sphere() {
  static const auto query = std::make_shared<const field::FieldQuery>(
      testing::dense_payload(
          {.origin_mm = Vec3::Constant(-20), .blocks = {4, 4, 4}, .inner_mm = 8, .outer_mm = 6},
          [](const Vec3& x, double t) {
            return x.norm() - 13 - 2 * std::sin(2 * std::numbers::pi * t / kPeriod);
          }),
      kPeriod);
  return query;
}

// The user wanders through the middle, the band, the outside, and states that are no numbers.
haptics::ServoState wander(int n) {
  const double t = 0.001 * n;
  haptics::ServoState state{t, Vec3(18 * std::sin(3.1 * t), 15 * std::cos(1.7 * t), 4 * t), true};
  if (n % 97 == 0) state.position_mm[1] = std::nan("");
  if (n % 89 == 0) state.valid = false;
  if (n % 83 == 0) state.time_s = INFINITY;
  if (n % 79 == 0) state.position_mm *= 1e12;
  return state;
}

TEST(Tick, CannotThrow) {
  static_assert(
      noexcept(std::declval<haptics::Servo&>().tick(std::declval<const haptics::ServoState&>())));
  static_assert(
      noexcept(std::declval<haptics::TwoStepModel&>().evaluate(std::declval<const Vec3&>(), 0.0)));
  static_assert(noexcept(std::declval<haptics::ForceModel&>().evaluate(
      std::declval<const haptics::ServoState&>(), std::declval<const haptics::Moment&>())));
  static_assert(noexcept(
      std::declval<const haptics::ShellModel&>().taxels(std::declval<const Vec3&>(), 0.0)));
  static_assert(noexcept(haptics::taxels_of(std::declval<haptics::ShellModel&>(),
                                            std::declval<const haptics::Published&>(), 0.0,
                                            std::declval<const Vec3&>(), 0.0)));
  static_assert(noexcept(std::declval<haptics::Watchdog&>().beat()));
  static_assert(noexcept(
      std::declval<haptics::SafetyStage&>().apply(std::declval<const Vec3&>(), 0.0, 0.0, true)));
  static_assert(
      noexcept(std::declval<const field::FieldQuery&>().sample(std::declval<const Vec3&>(), 0.0)));
}

TEST(Tick, TheCounterSeesAnAllocation) {
  allocations = 0;
  counting = true;
  frees = 0;
  { const std::vector<int> memory(10); }
  counting = false;
  EXPECT_EQ(allocations, 1);
  EXPECT_EQ(frees, 1);
}

TEST(Tick, AllocatesNothingInEitherModeWhateverTheState) {
  for (haptics::TimeMode mode : {haptics::TimeMode::Continuous, haptics::TimeMode::Published}) {
    haptics::Servo servo(haptics::two_step_scene(sphere(), {.time_mode = mode}), {});
    double largest = 0;
    bool finite = true;
    allocations = 0;
    counting = true;
    for (int n = 0; n < 20000; ++n) {
      const haptics::Tick tick = servo.tick(wander(n));
      finite = finite && tick.force_n.allFinite();
      largest = std::max(largest, tick.force_n.norm());
    }
    counting = false;
    EXPECT_EQ(allocations, 0);
    EXPECT_TRUE(finite);
    EXPECT_LE(largest, 3 + 1e-12);
  }
}

TEST(Tick, TaxelsAllocateNothing) {
  haptics::Taxels taxels(std::make_shared<const haptics::AtlasField>(sphere()), {.radius_mm = 4});
  double most = 0;
  allocations = 0;
  counting = true;
  for (int n = 0; n < 2000; ++n) {
    const Vec3 out = Vec3(std::sin(n), std::cos(n), std::sin(0.3 * n)).normalized();
    const haptics::TaxelMap map = taxels.under(
        {.proxy_mm = 17 * out, .normal = out, .force_n = out, .depth_mm = 2}, 0.001 * n);
    most = std::max(most, map.peak_kpa);
  }
  counting = false;
  EXPECT_EQ(allocations, 0);
  EXPECT_GT(most, 0);
}

TEST(Tick, TaxelsOfAFingertipAllocateNothing) {
  haptics::ShellModel model(std::make_shared<const haptics::AtlasField>(sphere()),
                            haptics::fingertip(4, 500), {});
  haptics::Published seen;
  seen.touching = true;
  double most = 0;
  allocations = 0;
  counting = true;
  for (int n = 0; n < 2000; ++n) {
    const Vec3 out = Vec3(std::sin(n), std::cos(n), std::sin(0.3 * n)).normalized();
    const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), out);
    const Vec3 at = 15 * out;
    seen.position_mm = {at.x(), at.y(), at.z()};
    seen.orientation = {turn.x(), turn.y(), turn.z(), turn.w()};
    seen.force_n = {out.x(), out.y(), out.z()};
    const haptics::TaxelMap map =
        haptics::taxels_of(model, seen, 0.001 * n, Vec3::UnitX(), n % 2 == 0 ? 0 : 0.3);
    most = std::max(most, map.peak_kpa);
  }
  counting = false;
  EXPECT_EQ(allocations, 0);
  EXPECT_GT(most, 0);
}

TEST(Tick, AllocatesNothingOnTheSimulatedDevicesLoop) {
  haptics::Servo servo(haptics::two_step_scene(sphere(), {}), {});
  device::SimulatedOptions options;
  options.path = {.anchor_m = Vec3(0.013, 0, 0),
                  .direction = -Vec3::UnitX(),
                  .offset_m = 0.002,
                  .amplitude_m = 0.004,
                  .frequency_hz = 1.5};
  options.hand.mass_kg = 0.2;
  options.seconds = 3;
  options.pace = device::Pace::Fast;
  device::SimulatedDevice device(options);
  double largest = 0;
  const device::ServoFn fn = [&](const device::DeviceState& state) -> Vec3 {
    if (!counting) {  // from the end of the first tick on
      allocations = 0;
      counting = true;
    }
    const haptics::Tick tick = servo.tick({state.time_s, 1000 * state.position_m, state.valid});
    largest = std::max(largest, tick.force_n.norm());
    return tick.force_n;
  };
  const device::RunReport report = device.run(fn, {});
  counting = false;
  EXPECT_EQ(allocations, 0);
  EXPECT_EQ(report.ticks, 3000);
  EXPECT_GT(largest, 0.1);
}

haptics::Scene touched(double radius_mm) {
  // One for all: a model with a tool as large takes over from the one before.
  static const auto field = std::make_shared<const haptics::AtlasField>(sphere());
  return {.model = std::make_unique<haptics::ProxyModel>(
              field, haptics::ProxyOptions{.radius_mm = radius_mm, .damping_n_s_per_m = 2}),
          .period_s = kPeriod};
}

TEST(Tick, AProxyThatIsRecordedPublishedWatchedAndSwappedAllocatesNothing) {
  haptics::Servo servo(touched(1), {.safety = {}, .heart = {}, .recorded_ticks = 500});
  haptics::Watchdog watchdog([] {}, {});
  bool finite = true;
  allocations = 0;
  frees = 0;
  for (int n = 0; n < 20000; ++n) {
    if (n % 1000 == 500) {  // what the caller's thread does
      servo.offer(touched(n % 4000 < 2000 ? 1 : 2));
      servo.set_rate_hz(0.5 + 0.0001 * n);
      servo.recorder().resume();
    }
    counting = true;
    const haptics::Tick tick = servo.tick(wander(n));
    (void)watchdog.beat();
    counting = false;
    finite = finite && tick.force_n.allFinite() && tick.force_n.norm() <= 3 + 1e-12;
  }
  EXPECT_EQ(allocations, 0);
  EXPECT_EQ(frees, 0);  // what was swapped out is the caller's to free
  EXPECT_TRUE(finite);
}

TEST(Tick, ACallersThreadMayDoAllItMayWhileTheServoRuns) {
  // Read by the thread sanitizer.
  haptics::Servo servo(touched(1), {.safety = {}, .heart = {}, .recorded_ticks = 200});
  std::atomic<bool> done{false};
  std::thread ticking([&] {
    for (int n = 0; n < 20000 || !done; ++n) (void)servo.tick(wander(n % 20000));
  });
  std::size_t dumped = 0;
  bool torn = false;
  double last_time_s = 0;
  // The other thread may not have run yet: until it has left a recording.
  for (int n = 0; n < 2000 || (dumped == 0 && n < 100000000); ++n) {
    const haptics::Published seen = servo.published();
    // Of one tick as a whole: this state's z is 4 mm/s times its time.
    const bool far_away = std::abs(seen.position_mm[0]) > 1e3;
    if (seen.status != haptics::TickStatus::Fault && !far_away) {
      torn = torn || std::abs(seen.position_mm[2] - 4 * seen.time_s) > 1e-9;
      last_time_s = seen.time_s;
    }
    servo.set_rate_hz(1 + 0.001 * (n % 100));
    servo.set_paused(n % 50 == 0);
    servo.hold_phase(n % 70 == 0 ? 0.3 : -1);
    if (n % 40 == 0) servo.offer(touched(1 + 0.01 * (n % 100)));
    if (n % 60 == 0) servo.restart();
    servo.recorder().ask();
    if (servo.recorder().frozen()) {
      dumped += servo.recorder().ticks().size();
      servo.recorder().resume();
    }
    std::this_thread::yield();
  }
  done = true;
  ticking.join();
  EXPECT_GT(dumped, 0U);
  EXPECT_FALSE(torn);
  EXPECT_GE(last_time_s, 0);
}

TEST(Tick, OneFieldServesManyThreads) {
  // Read by the thread sanitizer: servos share the field and nothing else.
  std::vector<std::thread> threads;
  std::vector<Vec3> sums(3, Vec3::Zero());
  for (Vec3& sum : sums) {
    threads.emplace_back([&sum, query = sphere()] {
      haptics::Servo servo(haptics::two_step_scene(query, {}), {});
      for (int n = 0; n < 5000; ++n) sum += servo.tick(wander(n)).force_n;
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_GT(sums[0].norm(), 0);
  EXPECT_EQ(sums[0], sums[1]);
  EXPECT_EQ(sums[0], sums[2]);
}

}  // namespace
}  // namespace beatlas
