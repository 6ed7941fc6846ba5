#include "runtime/haptics/safety.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "runtime/base/error.h"

namespace beatlas::haptics::safety_tests {
namespace {

constexpr double kTick = 0.001;
constexpr double kRounding = 1e-12;

// No ramp, so that each limit shows alone.
SafetyOptions without_ramp() {
  SafetyOptions options;
  options.start_ramp_s = 0;
  return options;
}

TEST(SafetyStage, CapsThePeakWithoutTurningTheForce) {
  // Hardly beyond the peak of 3 N, and far.
  for (const double size_n : {3.001, 3.5, 4.4, 10.0}) {
    SafetyStage stage(without_ramp());
    const Vec3 wanted = size_n * Vec3(1, -2, 2) / 3;
    SafeForce safe;
    for (int n = 0; n < 200; ++n) {
      safe = stage.apply(wanted, 5, n * kTick, true);
      EXPECT_LE(safe.force_n.norm(), 3 + kRounding) << size_n;
    }
    EXPECT_LT((safe.force_n - 3 * wanted.normalized()).norm(), 1e-9) << size_n;
    EXPECT_EQ(safe.status, TickStatus::Limited) << size_n;
  }
  // As large as a double can be, from where the slew does not hold it back.
  SafetyStage stage(without_ramp());
  for (int n = 0; n < 200; ++n) (void)stage.apply(Vec3(3, 0, 0), 5, n * kTick, true);
  const double huge = std::numeric_limits<double>::max();
  const double felt_n = stage.apply(Vec3(huge, huge, 0), 5, 0.2, true).force_n.norm();
  EXPECT_LE(felt_n, 3 + kRounding);
  EXPECT_GT(felt_n, 2.9);
}

TEST(SafetyStage, LimitsTheSlewOfAnyInput) {
  SafetyStage stage(without_ramp());
  std::mt19937 random(9);
  std::uniform_real_distribution<double> u(-4, 4);
  Vec3 last = Vec3::Zero();
  for (int n = 0; n < 5000; ++n) {
    const SafeForce safe = stage.apply(Vec3(u(random), u(random), u(random)), 1, n * kTick, true);
    EXPECT_LE((safe.force_n - last).norm(), 50 * kTick + kRounding);
    last = safe.force_n;
  }
}

TEST(SafetyStage, PassesASmallSlowForceUnchanged) {
  SafetyStage stage(without_ramp());
  for (int n = 0; n < 1000; ++n) {
    const Vec3 wanted(0.5 * std::sin(0.01 * n), 0, 0.001 * n);
    const SafeForce safe = stage.apply(wanted, 1, n * kTick, true);
    EXPECT_EQ(safe.force_n, wanted);
    EXPECT_EQ(safe.status, TickStatus::Ok);
  }
}

TEST(SafetyStage, BeyondTheLargestDepthTheForceIsThatOfThisDepth) {
  SafetyStage stage(without_ramp());
  SafeForce safe;
  for (int n = 0; n < 200; ++n) safe = stage.apply(Vec3(0.05 * 30, 0, 0), 30, n * kTick, true);
  EXPECT_NEAR(safe.force_n.x(), 0.05 * 15, 1e-9);
  EXPECT_EQ(safe.status, TickStatus::Limited);
}

TEST(SafetyStage, AFaultDropsToZeroAtOnceAndTheForceComesBackByARamp) {
  SafetyStage stage(SafetyOptions{});
  const Vec3 wanted(0, 2, 0);
  const double nan = std::nan("");
  struct Fault {
    Vec3 force_n;
    double depth_mm;
    double step_s;
    bool valid;
  };
  double t = 0;
  for (const Fault& fault :
       {Fault{Vec3(nan, 0, 0), 1, kTick, true}, Fault{wanted, nan, kTick, true},
        Fault{Vec3(0, INFINITY, 0), 1, kTick, true}, Fault{wanted, 1, nan, true},
        Fault{wanted, 1, kTick, false}, Fault{wanted, 1, -kTick, true},
        Fault{wanted, 1, 0.0101, true}}) {
    // Ramp of 0.5 s from the first good tick: force 2 t / 0.5.
    const double start = t + kTick;
    SafeForce safe;
    for (int n = 0; n < 600; ++n) {
      t += kTick;
      safe = stage.apply(wanted, 1, t, true);
      const double share = std::min(1.0, (t - start) / 0.5);
      ASSERT_NEAR(safe.force_n.y(), 2 * share, 1e-9);
    }
    EXPECT_EQ(safe.status, TickStatus::Ok);
    const SafeForce dropped =
        stage.apply(fault.force_n, fault.depth_mm, t + fault.step_s, fault.valid);
    EXPECT_EQ(dropped.status, TickStatus::Fault);
    EXPECT_TRUE(dropped.force_n.isZero());
    t += 0.02;
  }
}

TEST(SafetyStage, AClockThatStandsStillHoldsNoForce) {
  for (const Vec3& wanted : {Vec3(0, 2, 0), Vec3(0, 0, 0), Vec3(0, -2, 0)}) {
    SafetyStage stage(SafetyOptions{});
    SafeForce safe;
    for (int n = 0; n <= 1000; ++n) safe = stage.apply(Vec3(0, 2, 0), 1, n * kTick, true);
    ASSERT_NEAR(safe.force_n.y(), 2, 1e-9);
    const SafeForce repeated = stage.apply(wanted, 1, 1, true);
    EXPECT_NE(repeated.status, TickStatus::Fault) << "one time twice is a coarse clock";
    EXPECT_EQ(repeated.force_n, safe.force_n) << "no time, no change";
    for (int n = 0; n < 5000; ++n) {
      const SafeForce dropped = stage.apply(wanted, 1, 1, true);
      ASSERT_EQ(dropped.status, TickStatus::Fault) << n;
      ASSERT_TRUE(dropped.force_n.isZero()) << n;
    }
    // Time goes on: the ramp, from this tick on.
    for (int n = 1; n <= 1000; ++n) {
      safe = stage.apply(Vec3(0, 2, 0), 1, 1 + n * kTick, true);
      ASSERT_NEAR(safe.force_n.y(), 2 * std::min(1.0, (n - 1) * kTick / 0.5), 1e-9);
    }
    EXPECT_EQ(safe.status, TickStatus::Ok);
  }
}

TEST(SafetyStage, AClockOfWholeMillisecondsUnderAnUnsteadyLoopIsNoFault) {
  SafetyStage stage(without_ramp());
  for (int n = 0; n < 1000; ++n) {  // 0, 0, 2, 2, 4, ... ms
    const SafeForce safe = stage.apply(Vec3(1, 0, 0), 1, (n - n % 2) * kTick, true);
    ASSERT_NE(safe.status, TickStatus::Fault) << n;
    ASSERT_LE(safe.force_n.x(), 50 * n * kTick + kRounding) << n;
  }
}

TEST(SafetyStage, ARestartIsNoRepeatedTime) {
  SafetyStage stage(SafetyOptions{});
  for (int n = 0; n < 4; ++n) (void)stage.apply(Vec3(1, 0, 0), 1, 0, true);
  EXPECT_EQ(stage.apply(Vec3(1, 0, 0), 1, 0, true).status, TickStatus::Fault);
  stage.restart();
  EXPECT_NE(stage.apply(Vec3(1, 0, 0), 1, 0, true).status, TickStatus::Fault);
  const SafetyStage::Memory kept = stage.memory();
  SafetyStage other(SafetyOptions{});
  other.restore(kept);
  for (int n = 0; n < 3; ++n) {
    EXPECT_EQ(other.apply(Vec3(1, 0, 0), 1, 0, true).status,
              stage.apply(Vec3(1, 0, 0), 1, 0, true).status);
    EXPECT_EQ(other.memory(), stage.memory());
  }
  SafetyStage::Memory none = kept;
  for (const double no_state : {-1.0, 4.0, 1e300, std::nan("")}) {
    none[5] = no_state;
    other.restore(none);
    EXPECT_EQ(other.memory()[5], 0) << no_state;
  }
}

TEST(SafetyStage, StoppedStaysAtZeroUntilRestarted) {
  SafetyStage stage(SafetyOptions{});
  stage.stop();
  for (int n = 0; n < 10; ++n) {
    const SafeForce safe = stage.apply(Vec3(1, 0, 0), 1, n * kTick, true);
    EXPECT_EQ(safe.status, TickStatus::Fault);
    EXPECT_TRUE(safe.force_n.isZero());
  }
  stage.restart();
  EXPECT_NE(stage.apply(Vec3(1, 0, 0), 1, 0.011, true).status, TickStatus::Fault);
  EXPECT_GT(stage.apply(Vec3(1, 0, 0), 1, 0.012, true).force_n.x(), 0);
}

TEST(SafetyStage, RefusesLimitsThatWouldBeNone) {
  for (double bad : {0.0, -1.0, std::nan(""), double(INFINITY)}) {
    SafetyOptions options;
    options.peak_n = bad;
    EXPECT_THROW(SafetyStage{options}, Error);
    options = {};
    options.slew_n_per_s = bad;
    EXPECT_THROW(SafetyStage{options}, Error);
    options = {};
    options.max_gap_s = bad;
    EXPECT_THROW(SafetyStage{options}, Error);
  }
}

TEST(TorqueStage, IsNoLargerThanTheModelsAndNeverJumps) {
  constexpr double kArmMm = 10;
  const double most = SafetyOptions{}.slew_n_per_s * kArmMm * kTick;
  TorqueStage stage(SafetyOptions{}.slew_n_per_s, kArmMm);
  const Vec3 torque(5, 0, 0);
  // The force is all but nothing and still going down; its share would be a thousand.
  const SafeForce safe{Vec3(0, 1, 0), TickStatus::Limited};
  Vec3 last = Vec3::Zero();
  for (int n = 1; n < 40; ++n) {
    const Vec3 felt = stage.apply(torque, Vec3(0, 1e-3, 0), safe, n * kTick);
    EXPECT_LE((felt - last).norm(), most + 1e-12) << n;
    EXPECT_LE(felt.norm(), torque.norm() + 1e-12) << n;
    last = felt;
  }
  EXPECT_TRUE(last.isApprox(torque));
  const SafeForce half{Vec3(0, 1, 0), TickStatus::Limited};
  for (int n = 40; n < 80; ++n) last = stage.apply(torque, Vec3(0, 2, 0), half, n * kTick);
  EXPECT_TRUE(last.isApprox(0.5 * torque)) << "as the force was halved";
  EXPECT_TRUE(stage.apply(torque, Vec3(0, 2, 0), {}, 80 * kTick).isZero()) << "a fault";
}

TEST(TorqueStage, BeginsWithNoneWhereverTheClockStands) {
  const Vec3 torque(5, 0, 0);
  const SafeForce whole{Vec3(0, 2, 0), TickStatus::Ok};
  for (const double start_s : {-5.0, 0.0, 1e5}) {
    TorqueStage stage(SafetyOptions{}.slew_n_per_s, 10);
    for (int again = 0; again < 2; ++again) {  // and after a fault, from an earlier time
      EXPECT_TRUE(stage.apply(torque, whole.force_n, whole, start_s).isZero()) << start_s;
      EXPECT_NEAR(stage.apply(torque, whole.force_n, whole, start_s + kTick).x(), 0.5, 1e-6);
      (void)stage.apply(torque, whole.force_n, {}, again == 0 ? start_s + 9 : std::nan(""));
    }
  }
}

}  // namespace
}  // namespace beatlas::haptics::safety_tests
