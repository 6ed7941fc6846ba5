// The servo around a model: hard cases 8 and 15, recording and replay, publication.

#include "runtime/haptics/servo.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "runtime/haptics/proxy.h"
#include "runtime/haptics/watchdog.h"
#include "tests/unit/runtime_haptics/closed_forms.h"

namespace beatlas::haptics::servo_tests {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kTick = 0.001;
constexpr double kBeat = 0.75;

std::shared_ptr<const ContactField> beating(double radius_mm) {
  return testing::packed({.origin_mm = Vec3::Constant(-27.9),
                          .blocks = {5, 5, 5},
                          .rr_interval_s = kBeat,
                          .inner_mm = 12,
                          .outer_mm = 6},
                         [=](const Vec3& x, double t) {
                           return x.norm() - radius_mm - 2 * std::sin(2 * kPi * t / kBeat);
                         });
}

Scene scene(double radius_mm = 18, const ProxyOptions& options = {}) {
  return {.model = std::make_unique<ProxyModel>(beating(radius_mm), options), .period_s = kBeat};
}

TEST(HardCase8, CycleWrapAndChangesOfHeartRateMakeNoLargerStepsThanAnyBeat) {
  Servo servo(scene(), {});
  const Vec3 x = 14.5 * Vec3(2, 1, -2) / 3;
  double last = 0;
  const auto largest_step = [&](int from, int to) {
    double largest = 0;
    for (int n = from; n < to; ++n) {
      const double force =
          servo.tick({.time_s = kTick * n, .position_mm = x}).contact.force_n.norm();
      if (n > 0) largest = std::max(largest, std::abs(force - last));
      last = force;
    }
    return largest;
  };
  // Steps at 80/min in the middle of the cycle, all but 20 ms each side of the wrap.
  double mid_cycle = 0;
  for (int beat = 0; beat < 4; ++beat) {
    const int start = 750 * beat;
    (void)largest_step(start, start + 20);
    mid_cycle = std::max(mid_cycle, largest_step(start + 20, start + 730));
    (void)largest_step(start + 730, start + 750);
  }
  double at_wrap = 0;
  for (int beat = 4; beat < 8; ++beat) {
    at_wrap = std::max(at_wrap, largest_step(750 * beat, 750 * beat + 20));
    (void)largest_step(750 * beat + 20, 750 * beat + 730);
    at_wrap = std::max(at_wrap, largest_step(750 * beat + 730, 750 * beat + 750));
  }
  EXPECT_LE(at_wrap, 1.1 * mid_cycle);
  // Slower by each of these, in contact, at an odd moment; never faster than 80/min.
  int n = 6000 + 123;
  double changed = largest_step(6000, n);
  for (double rate_hz : {0.5, 80.0 / 60, 0.9, 0.3, 80.0 / 60}) {
    servo.set_rate_hz(rate_hz);
    changed = std::max(changed, largest_step(n, n + 377));
    n += 377;
  }
  servo.set_paused(true);
  changed = std::max(changed, largest_step(n, n + 500));
  servo.set_paused(false);
  servo.hold_phase(0.3);
  changed = std::max(changed, largest_step(n + 500, n + 4000));
  EXPECT_LE(changed, 1.1 * mid_cycle);
  EXPECT_NEAR(servo.published().phase, 0.3, 1e-4);
  EXPECT_GT(mid_cycle, 0.001);
}

TEST(HardCase8, AtTwiceTheRateStepsGrowWithTheSpeedAndNoMore) {
  Servo servo(scene(), {});
  servo.set_rate_hz(160.0 / 60);
  const Vec3 x = 14.5 * Vec3(2, 1, -2) / 3;
  double last = 0;
  for (int n = 0; n < 4000; ++n) {
    const Tick tick = servo.tick({.time_s = kTick * n, .position_mm = x});
    const double force = tick.contact.force_n.norm();
    // K times the surface's speed: 2 mm of amplitude at the rate of now.
    const double speed = 2 * 2 * kPi * servo.published().rate_hz;
    if (n > 0) {
      EXPECT_LE(std::abs(force - last), 1.1 * 0.150 * speed * kTick);
    }
    if (n > 2000 && std::abs(tick.contact.depth_mm - 3.5) < 0.05) {
      EXPECT_NEAR(std::abs(tick.contact.surface_velocity_mm_s), speed, 0.05 * speed);
    }
    last = force;
  }
}

struct Hand {
  Servo& servo;
  double t = 0;
  Tick next(const Vec3& x, bool valid = true, double step_s = kTick) {
    t += step_s;
    return servo.tick({.time_s = t, .position_mm = x, .valid = valid});
  }
};

TEST(HardCase15, EveryFaultIsZeroForceInItsTickAndARampAfterwards) {
  Servo servo(scene(), {});
  Hand hand{servo};
  const Vec3 inside(0, 0, 13);
  const double nan = std::nan("");
  const auto settle = [&] {
    Tick tick;
    for (int n = 0; n < 600; ++n) tick = hand.next(inside);
    return tick.force_n.norm();
  };
  const auto expect_fault_and_ramp = [&](const Tick& fault) {
    EXPECT_EQ(fault.status, TickStatus::Fault);
    EXPECT_TRUE(fault.force_n.isZero());
    if (!std::isfinite(hand.t)) hand.t = 0;
    EXPECT_LT(hand.next(inside).force_n.norm(), 0.01);  // the start ramp
  };
  // Start inside: at first nothing, then more by and by, never by more than the slew limit.
  double last = 0;
  for (int n = 0; n < 500; ++n) {
    const double force = hand.next(inside).force_n.norm();
    EXPECT_LE(force, 3.0 * n / 500 + 1e-9);
    EXPECT_LE(std::abs(force - last), 50 * kTick + 1e-9);
    last = force;
  }
  EXPECT_GT(settle(), 0.3);
  expect_fault_and_ramp(hand.next(inside, true, 0.0101));  // a late tick
  EXPECT_GT(settle(), 0.3);
  expect_fault_and_ramp(hand.next(Vec3(0, nan, 0)));
  EXPECT_GT(settle(), 0.3);
  expect_fault_and_ramp(hand.next(inside, false));  // unplugged
  EXPECT_GT(settle(), 0.3);
  servo.offer(scene(19));  // hot swap
  expect_fault_and_ramp(hand.next(inside));
  EXPECT_GT(settle(), 0.3);
  servo.stop();
  EXPECT_TRUE(hand.next(inside).force_n.isZero());
  EXPECT_TRUE(hand.next(inside).force_n.isZero());
  servo.restart();
  EXPECT_LT(hand.next(inside).force_n.norm(), 0.01);
  EXPECT_GT(settle(), 0.3);
}

TEST(HardCase15, NoContactEverRaisesForceWhileTheDeviceIsInvalid) {
  Servo servo(scene(), {});
  Hand hand{servo};
  for (int n = 0; n < 2000; ++n) {
    const Vec3 x(0, 0, 25 - 0.01 * n);
    const bool valid = (n / 100) % 2 == 0;
    const Tick tick = hand.next(x, valid);
    if (!valid) {
      ASSERT_TRUE(tick.force_n.isZero());
      ASSERT_TRUE(tick.contact.force_n.isZero());
      ASSERT_EQ(tick.status, TickStatus::Fault);
    }
  }
}

TEST(HardCase15, AStallIsSeenWithinTenMillisecondsWhateverItsPhase) {
  using namespace std::chrono_literals;
  const WatchdogOptions options;
  // Told its times: beats every ms, then none; looks every 2 ms, at any offset to the beats.
  for (auto offset = 0us; offset < 2000us; offset += 100us) {
    int dropped = 0;
    Watchdog watchdog([&] { ++dropped; }, {.limit_s = options.limit_s, .period_s = 0.1});
    const auto start = Watchdog::Clock::time_point(1h);
    EXPECT_FALSE(watchdog.look_at(start));  // nothing runs yet
    for (auto t = 0ms; t <= 100ms; t += 1ms) EXPECT_TRUE(watchdog.beat_at(start + t));
    auto seen = start + 1h;
    for (auto t = offset; t < 30000us; t += 2000us) {
      if (watchdog.look_at(start + 100ms + t)) seen = std::min(seen, start + 100ms + t);
    }
    EXPECT_LE(seen - (start + 100ms), 10ms);
    EXPECT_EQ(dropped, 1);
    EXPECT_EQ(watchdog.stalls(), 1);
    EXPECT_FALSE(watchdog.beat_at(start + 150ms));  // that tick's force is too old
    EXPECT_TRUE(watchdog.beat_at(start + 151ms));
    watchdog.rest();
    EXPECT_FALSE(watchdog.look_at(start + 1min));
  }
}

TEST(HardCase15, TheWatchdogsThreadDropsTheForceOfAServoThatHangs) {
  std::atomic<bool> dropped{false};
  Watchdog watchdog([&] { dropped = true; }, {});
  for (int n = 0; n < 5; ++n) (void)watchdog.beat();
  // Hangs until it is seen; without a watchdog this would never end.
  while (!dropped) std::this_thread::yield();
  EXPECT_FALSE(watchdog.beat());
  EXPECT_GE(watchdog.stalls(), 1);
  EXPECT_THROW(Watchdog(nullptr, {}), Error);
  EXPECT_THROW(Watchdog([] {}, {.limit_s = 0}), Error);
  EXPECT_THROW(Watchdog([] {}, {.period_s = std::nan("")}), Error);
}

Vec3 wander(double t) {
  return {17 * std::sin(1.3 * t), 14 * std::cos(0.7 * t), 9 * std::sin(2.9 * t)};
}

TEST(Recorder, KeepsTheLastTicksAndReplaysThemToTheBit) {
  Servo servo(scene(18, {.radius_mm = 1, .damping_n_s_per_m = 2}),
              {.safety = {}, .heart = {}, .recorded_ticks = 3000});
  Hand hand{servo};
  for (int n = 0; n < 10000; ++n) {
    if (n == 7500) servo.set_rate_hz(2);
    if (n == 8000) servo.restart();
    if (n == 8500) servo.hold_phase(0.4);
    if (n == 9000) servo.set_paused(true);
    (void)hand.next(wander(hand.t), n % 977 != 0 || n < 7000);
  }
  // The first fault freezes the ring a hundred ticks later.
  EXPECT_TRUE(servo.recorder().frozen());
  const std::vector<TickRecord> ticks = servo.recorder().ticks();
  ASSERT_EQ(ticks.size(), 3000U);
  EXPECT_EQ(ticks[2899].status, TickStatus::Fault);
  EXPECT_NEAR(ticks[2899].time_s - ticks[0].time_s, 2.899, 1e-9);

  std::stringstream file;
  write_ticks(file, "{\"atlas\":\"x\"}", ticks);
  const RecordedTicks read = read_ticks(file, "ticks.txt");
  EXPECT_EQ(read.about, "{\"atlas\":\"x\"}");
  ASSERT_EQ(read.ticks.size(), ticks.size());
  Servo again(scene(18, {.radius_mm = 1, .damping_n_s_per_m = 2}), {});
  const ReplayReport report = replay_ticks(again, read.ticks);
  EXPECT_EQ(report.ticks, 3000U);
  EXPECT_EQ(report.different, 0U) << report.first_different;
  // Another model is found out.
  Servo other(scene(18, {.radius_mm = 1.01, .damping_n_s_per_m = 2}), {});
  EXPECT_GT(replay_ticks(other, read.ticks).different, 100U);

  servo.recorder().resume();
  EXPECT_FALSE(servo.recorder().frozen());
  for (int n = 0; n < 10; ++n) (void)hand.next(wander(hand.t));
  servo.recorder().ask();
  (void)hand.next(wander(hand.t));
  EXPECT_TRUE(servo.recorder().frozen());
  EXPECT_EQ(servo.recorder().ticks().size(), 11U);
}

TEST(Recorder, NumbersThatAreNoneComeBackToo) {
  std::vector<TickRecord> ticks(1);
  ticks[0].time_s = -0.0;
  ticks[0].position_mm = {std::nan(""), INFINITY, -INFINITY};
  ticks[0].distance_mm = 5e-324;
  std::stringstream file;
  write_ticks(file, "", ticks);
  const TickRecord read = read_ticks(file, "t").ticks.at(0);
  EXPECT_TRUE(std::signbit(read.time_s));
  EXPECT_TRUE(std::isnan(read.position_mm[0]));
  EXPECT_EQ(read.position_mm[1], INFINITY);
  EXPECT_EQ(read.position_mm[2], -INFINITY);
  EXPECT_EQ(read.distance_mm, 5e-324);
}

TEST(Recorder, ADamagedFileIsRefusedWithItsPlace) {
  std::stringstream sound;
  write_ticks(sound, "about", std::vector<TickRecord>(2));
  const auto expect = [](const std::string& text, const std::string& words) {
    std::istringstream in(text);
    try {
      (void)read_ticks(in, "t.txt");
      ADD_FAILURE() << words;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
  };
  const std::string text = sound.str();
  expect("", "no recording");
  expect("t_s,x\n", "no recording");
  expect("beatlas ticks 1\nabout\n", "line 3");
  expect("beatlas ticks 1\nabout\nt_s\n0\n", "columns are not");
  expect(text + "0,1,2\n", "line 6, column x_mm_2");
  expect(text.substr(0, text.size() - 1) + ",7\n", "line 5: there are too many");
  std::string bad_flag = text;
  const std::size_t row = bad_flag.find("\n0,") + 1;
  bad_flag.replace(row, 1, "x");
  expect(bad_flag, "line 4, column t_s");
}

TEST(Servo, PublishesEachTickAsAWhole) {
  Servo servo(scene(), {});
  Hand hand{servo};
  const Tick tick = hand.next(Vec3(0, 0, 13));
  const Published seen = servo.published();
  EXPECT_EQ(seen.ticks, 1U);
  EXPECT_EQ(seen.position_mm[2], 13);
  EXPECT_EQ(seen.proxy_mm[2], tick.contact.proxy_mm.z());
  EXPECT_EQ(seen.distance_mm, tick.contact.distance_mm);
  EXPECT_TRUE(seen.touching);
}

TEST(Servo, AnotherStiffnessOnTheSameFieldGoesOnWithoutAFault) {
  const auto field = beating(18);
  const auto stiff = [&](double n_per_m, double radius_mm = 0) {
    return Scene{.model = std::make_unique<ProxyModel>(
                     field, ProxyOptions{.stiffness_n_per_m = n_per_m, .radius_mm = radius_mm}),
                 .period_s = kBeat};
  };
  Servo servo(stiff(150), {});
  Hand hand{servo};
  servo.set_paused(true);
  const Vec3 inside(0, 0, 13);
  Tick before;
  for (int n = 0; n < 1000; ++n) before = hand.next(inside);
  const double first_n = before.force_n.norm();
  ASSERT_GT(first_n, 0.3);
  for (const double n_per_m : {160.0, 50.0, 150.0}) {
    servo.offer(stiff(n_per_m));
    for (int n = 0; n < 100; ++n) {
      const Tick tick = hand.next(inside);
      EXPECT_NE(tick.status, TickStatus::Fault) << n_per_m << ' ' << n;
      EXPECT_LE((tick.force_n - before.force_n).norm(), 50 * kTick + 1e-9) << n_per_m << ' ' << n;
      before = tick;
    }
    EXPECT_NEAR(before.force_n.norm(), n_per_m / 150 * first_n, 0.01 * first_n);
  }
  // A tool of another shape is another contact, and so is another field.
  servo.offer(stiff(150, 2));
  EXPECT_EQ(hand.next(inside).status, TickStatus::Fault);
  EXPECT_NE(hand.next(inside).status, TickStatus::Fault);
  servo.offer(scene());
  EXPECT_EQ(hand.next(inside).status, TickStatus::Fault);
}

TEST(Servo, AnAtlasOfAnotherPeriodGoesOnAtTheSamePhase) {
  Servo servo(scene(), {});
  Hand hand{servo};
  for (int n = 0; n < 1000; ++n) (void)hand.next(Vec3(0, 0, 25));
  const double phase = servo.published().phase;
  Scene slow = scene();
  slow.period_s = 2;
  servo.offer(std::move(slow));
  servo.collect();
  (void)hand.next(Vec3(0, 0, 25));
  EXPECT_NEAR(servo.published().phase, phase, 1e-12);
  for (int n = 0; n < 100; ++n) (void)hand.next(Vec3(0, 0, 25));
  EXPECT_GT(servo.published().phase, phase);
  EXPECT_THROW(servo.offer({}), Error);
  Scene bad = scene();
  bad.period_s = 0;
  EXPECT_THROW(servo.offer(std::move(bad)), Error);
}

}  // namespace
}  // namespace beatlas::haptics::servo_tests
