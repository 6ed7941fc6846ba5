#include "runtime/haptics/heart_clock.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "runtime/base/error.h"

namespace beatlas::haptics {
namespace {

constexpr double kTick = 0.001;
constexpr double kPeriod = 0.8;

TEST(HeartClock, GoesAtTheAtlassOwnRateUnlessToldOtherwise) {
  HeartClock clock(kPeriod, {});
  for (int n = 0; n < 8000; ++n) clock.advance(kTick, clock.first_wish());
  EXPECT_NEAR(clock.beats(), 10, 1e-9);
  EXPECT_NEAR(clock.field_time_s(), 8, 1e-9);
  EXPECT_NEAR(clock.speed(), 1, 1e-12);
  HeartClock quick(kPeriod, {.rate_per_min = 150});
  for (int n = 0; n < 4000; ++n) quick.advance(kTick, quick.first_wish());
  EXPECT_NEAR(quick.beats(), 10, 1e-9);
  EXPECT_NEAR(quick.speed(), 2, 1e-12);
}

TEST(HeartClock, ARateIsApproachedExponentiallyWithoutAJumpOfPhaseOrRate) {
  HeartClock clock(kPeriod, {.settling_s = 0.2});
  const HeartWish quick{.rate_hz = 2.5};
  double last = 0;
  double last_rate = 1.25;
  for (int n = 1; n <= 2000; ++n) {
    clock.advance(kTick, quick);
    const double t = kTick * n;
    // The closed form, whatever the length of the ticks.
    EXPECT_NEAR(clock.rate_hz(), 2.5 - 1.25 * std::exp(-t / 0.2), 1e-9);
    EXPECT_NEAR(clock.beats(), 2.5 * t - 1.25 * 0.2 * (1 - std::exp(-t / 0.2)), 1e-9);
    EXPECT_LE(clock.beats() - last, 2.5 * kTick + 1e-12);
    EXPECT_LE(std::abs(clock.rate_hz() - last_rate), 1.25 * kTick / 0.2 + 1e-12);
    last = clock.beats();
    last_rate = clock.rate_hz();
  }
}

TEST(HeartClock, APauseRollsOutAndGoesOnFromThere) {
  HeartClock clock(kPeriod, {});
  for (int n = 0; n < 1000; ++n) clock.advance(kTick, clock.first_wish());
  HeartWish pause = clock.first_wish();
  pause.paused = true;
  const double from = clock.beats();
  for (int n = 0; n < 5000; ++n) clock.advance(kTick, pause);
  EXPECT_NEAR(clock.beats(), from + 1.25 * 0.25, 1e-6);
  EXPECT_LT(clock.speed(), 1e-6);
  const double paused = clock.beats();
  for (int n = 0; n < 10; ++n) clock.advance(kTick, clock.first_wish());
  EXPECT_GT(clock.beats(), paused);
  EXPECT_LT(clock.beats(), paused + 0.001);
}

TEST(HeartClock, AHoldStopsExactlyOnItsPhaseFromAnyPhaseAndRate) {
  for (double hold : {0.0, 0.2, 0.37, 0.999, 1.0}) {
    for (int start = 0; start < 800; start += 37) {
      HeartClock clock(kPeriod, {});
      for (int n = 0; n < start; ++n) clock.advance(kTick, clock.first_wish());
      HeartWish wish{.rate_hz = start % 2 == 0 ? 1.25 : 3.0, .hold_phase = hold};
      double last = clock.beats();
      double last_rate = clock.rate_hz();
      for (int n = 0; n < 6000; ++n) {
        clock.advance(kTick, wish);
        ASSERT_GE(clock.beats(), last);
        ASSERT_LE(clock.beats() - last, 3.0 * kTick * 1.01);
        // A rate of 3 1/s that rolls out, and what a tick's place may add where that begins.
        ASSERT_LE(std::abs(clock.rate_hz() - last_rate), 3.0 * 2.1 * kTick / 0.25);
        last = clock.beats();
        last_rate = clock.rate_hz();
      }
      double off = std::abs(clock.phase() - hold);
      off = std::min(off, std::abs(1 - off));
      EXPECT_LT(off, 1e-6) << hold << " from " << start;
      // Another phase, then on.
      wish.hold_phase = 0.5;
      for (int n = 0; n < 8000; ++n) clock.advance(kTick, wish);
      EXPECT_NEAR(clock.phase(), 0.5, 1e-6);
    }
  }
}

TEST(HeartClock, WhatIsNoWishChangesNothingForGood) {
  HeartClock clock(kPeriod, {});
  clock.advance(std::nan(""), clock.first_wish());
  clock.advance(-1, clock.first_wish());
  EXPECT_EQ(clock.beats(), 0);
  for (double bad : {std::nan(""), 1e9, -5.0, double(INFINITY)}) {
    for (int n = 0; n < 100; ++n) clock.advance(kTick, {.rate_hz = bad, .hold_phase = bad});
    EXPECT_TRUE(std::isfinite(clock.beats()));
    EXPECT_LE(clock.rate_hz(), HeartClock::kFastestHz);
    EXPECT_GE(clock.rate_hz(), 0);
  }
}

TEST(HeartClock, RefusesOptionsOutOfRange) {
  EXPECT_THROW(HeartClock(0, {}), Error);
  EXPECT_THROW(HeartClock(kPeriod, {.rate_per_min = 5}), Error);
  EXPECT_THROW(HeartClock(kPeriod, {.rate_per_min = std::nan("")}), Error);
  EXPECT_THROW(HeartClock(kPeriod, {.settling_s = 0}), Error);
}

}  // namespace
}  // namespace beatlas::haptics
