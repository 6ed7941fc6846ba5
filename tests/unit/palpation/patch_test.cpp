#include "runtime/palpation/patch.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/base/error.h"

namespace beatlas::palpation {
namespace {

constexpr double kK = 75;  // the middle of Table 1
constexpr double kCv = 60;
constexpr double kKc = 800;
constexpr double kFiveGramForceN = 0.049;

VerticalPatch massless() {
  return VerticalPatch({.mass_kg = 0, .damping_n_s_per_m = kCv, .contact_n_per_m = kKc});
}

TEST(Patch, PressedRelaxesWithTheContactsTimeConstantToThePrintedStiffness) {
  VerticalPatch patch = massless();
  const double ramp_s = 0.05;
  const double depth = 0.008;
  double force = patch.advance(depth, kK, ramp_s);
  // y' = (K_c d - (K_c + K_s) y) / C with d = r t.
  const double tau = kCv / kKc;
  const double share = kKc / (kKc + kK * kKc / (kKc - kK));
  const double rate = depth / ramp_s;
  const double dent = share * rate * (ramp_s + tau * std::expm1(-ramp_s / tau));
  EXPECT_NEAR(patch.dent_m(), dent, 1e-12 * dent);
  EXPECT_NEAR(force, kKc * (depth - dent), 1e-12 * force);
  force = patch.advance(depth, kK, 0.1);
  const double later = share * depth + (dent - share * depth) * std::exp(-0.1 / tau);
  EXPECT_NEAR(patch.dent_m(), later, 1e-12 * later);
  EXPECT_NEAR(patch.advance(depth, kK, 100), kK * depth, 1e-11);
}

TEST(Patch, LetGoRecoversInThePrintedTime) {
  VerticalPatch patch = massless();
  patch.advance(0.008, kK, 0.05);
  patch.advance(0.008, kK, 100);
  const double dent = patch.dent_m();
  const double force = patch.advance(-0.01, kK, 1e-9);  // gone within a nanosecond
  EXPECT_EQ(force, 0);
  for (double t : {0.2, 0.8, 2.0}) {
    VerticalPatch free = patch;
    free.advance(-0.01, kK, t);
    EXPECT_NEAR(free.dent_m(), dent * std::exp(-kK / kCv * t), 1e-8 * dent);
    EXPECT_FALSE(free.touching());
  }
}

TEST(Patch, GivesTheSameSamplesForStepsOfAnyLength) {
  // Corners 20 ms apart; the finger leaves the recovering wall and meets it again between them.
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-0.006, 0.01);
  std::vector<double> corners{0};
  for (int n = 0; n < 100; ++n) corners.push_back(any(random));
  for (double mass : {0.0, 1e-9, 1.14e-3, 0.02}) {
    std::vector<double> whole;
    int parted = 0;
    for (int parts : {1, 4, 20, 80}) {
      VerticalPatch patch({.mass_kg = mass, .damping_n_s_per_m = kCv, .contact_n_per_m = kKc});
      std::vector<double> samples;
      for (std::size_t n = 1; n < corners.size(); ++n) {
        const bool before = patch.touching();
        for (int part = 1; part <= parts; ++part) {
          patch.advance(corners[n - 1] + (corners[n] - corners[n - 1]) * part / parts, kK,
                        0.02 / parts);
        }
        parted += before && !patch.touching() ? 1 : 0;
        samples.push_back(patch.dent_m());
      }
      if (parts == 1) whole = samples;
      for (std::size_t n = 0; n < samples.size(); ++n) {
        EXPECT_NEAR(samples[n], whole[n], 1e-12) << mass << " kg in " << parts << " parts, " << n;
      }
    }
    EXPECT_GT(parted, 40);
  }
}

TEST(Patch, NeverGivesBackMoreThanItWasGiven) {
  // Work at the finger by fine steps, whatever the path, masses and springs.
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-0.01, 0.015);
  for (double mass : {0.0, 1e-9, 1.14e-3, 0.31}) {
    for (double stiffness : {0.0, 45.0, 133.0, 700.0}) {
      VerticalPatch patch({.mass_kg = mass, .damping_n_s_per_m = kCv, .contact_n_per_m = kKc});
      double work_j = 0;
      double depth = 0;
      double force = 0;
      for (int corner = 0; corner < 60; ++corner) {
        const double next = any(random);
        constexpr int kParts = 400;
        const double from = depth;
        for (int part = 1; part <= kParts; ++part) {
          const double to = from + (next - from) * part / kParts;
          const double push = patch.advance(to, stiffness, 0.04 / kParts);
          work_j += 0.5 * (push + force) * (to - depth);
          depth = to;
          force = push;
          ASSERT_GE(push, 0);
          // Trapezoids of 0.1 ms err by less than a ten thousandth of a press.
          ASSERT_LE(patch.energy_j(), work_j + 2e-6) << mass << " kg, " << stiffness << " N/m";
        }
      }
      EXPECT_GT(work_j, 1e-3);
    }
  }
}

TEST(Patch, UnforcedEnergyNeverGrowsWhileTheFingerStands) {
  for (double depth : {-0.005, 0.004, 0.008}) {
    for (double step : {1e-5, 1e-3, 0.05}) {
      VerticalPatch patch({.mass_kg = 1.14e-3, .damping_n_s_per_m = kCv, .contact_n_per_m = kKc});
      patch.advance(0.008, kK, 0.02);
      patch.advance(depth, kK, 0.001);
      double before = patch.energy_j();
      for (int n = 0; n < 1000; ++n) {
        patch.advance(depth, kK, step);
        ASSERT_LE(patch.energy_j(), before * (1 + 1e-12) + 1e-24);
        before = patch.energy_j();
      }
    }
  }
}

TEST(Patch, HardCase12ThroughAQuantisedEncoderNeitherChattersNorMakesEnergy) {
  // A device of 45 g and an encoder of 55 um, pressed against the patch by a hand of 0.4 N.
  constexpr double kEncoderM = 55e-6;
  constexpr double kDeviceKg = 0.045;
  constexpr double kTickS = 0.001;
  VerticalPatch patch({});
  double x = -0.002;
  double v = 0.05;
  double force = 0;
  double worst_n = 0;
  double given_j = 0;  // to the patch by the device
  double most_made_j = 0;
  double seen_m = 0;
  for (int tick = 0; tick < 8000; ++tick) {
    const double hand_n = 0.3 + 0.25 * std::sin(2 * std::numbers::pi * 1.5 * tick * kTickS);
    const double next_seen = kEncoderM * std::floor(x / kEncoderM);
    const double next = patch.advance(next_seen, kK, kTickS);
    // Beyond what the finger's own motion asks of the spring.
    worst_n = std::max(worst_n, std::abs(next - force) - kKc * std::abs(v) * kTickS);
    force = next;
    seen_m = next_seen;
    for (int part = 0; part < 20; ++part) {  // the device's mass, the force held over a tick
      const double h = kTickS / 20;
      v += h * (hand_n - force - 0.5 * v) / kDeviceKg;
      x += h * v;
      given_j += force * v * h;
    }
    most_made_j = std::max(most_made_j, -given_j);
  }
  EXPECT_GT(seen_m, 0.001);
  EXPECT_LE(worst_n, kFiveGramForceN);
  EXPECT_LE(most_made_j, 1e-6);
}

TEST(Patch, TakesEveryExtreme) {
  std::mt19937 random(11);
  for (double mass : {1e-9, 1e-6, 1e-3, 0.31}) {
    for (double stiffness : {0.0, 1e-3, 75.0, 1e5}) {
      for (double contact : {100.0, 800.0, 1e6}) {
        VerticalPatch patch(
            {.mass_kg = mass, .damping_n_s_per_m = kCv, .contact_n_per_m = contact});
        patch.advance(0, stiffness, 0.001);
        double largest = 0;
        for (int tick = 0; tick < 200; ++tick) {
          const bool pressed = (tick / 20) % 2 == 0;  // 10 mm within 1 ms, then let go at once
          const double force = patch.advance(pressed ? 0.01 : -0.05, stiffness, 0.001);
          ASSERT_TRUE(std::isfinite(force) && std::isfinite(patch.dent_m()));
          ASSERT_GE(force, 0);
          largest = std::max(largest, force);
        }
        EXPECT_LE(largest, contact * 0.0101 + 0.31 * 10 / 0.001);
      }
    }
  }
}

TEST(Patch, StateIsTakenUpAgainToTheBit) {
  VerticalPatch first({});
  for (int n = 0; n < 30; ++n) first.advance(0.0003 * n, kK + n, 0.001);
  VerticalPatch second({});
  second.restore(first.state());
  for (int n = 0; n < 30; ++n) {
    EXPECT_EQ(first.advance(0.009 - 0.0005 * n, kK, 0.001),
              second.advance(0.009 - 0.0005 * n, kK, 0.001));
  }
}

TEST(Patch, KelvinVoigtRespondsAsPrinted) {
  for (int parts : {1, 10, 333}) {
    KelvinVoigtPatch patch(0, kCv, kK);
    for (int n = 1; n <= parts; ++n) patch.push(0.6 * n / parts, 0.3 / parts);
    const double tau = kCv / kK;
    const double dent = 0.6 / 0.3 / kK * (0.3 + tau * std::expm1(-0.3 / tau));
    EXPECT_NEAR(patch.wall().place_m, dent, 1e-12 * dent);
    patch.push(0, 0);
    patch.push(0, 0.5);
    EXPECT_NEAR(patch.wall().place_m, dent * std::exp(-0.5 / tau), 1e-12 * dent);
  }
  const KelvinVoigtPatch patch(1.14e-3, kCv, kK);
  EXPECT_NEAR(patch.reaction_n(0.008, 0.05, 2), 75 * 0.008 + 60 * 0.05 + 1.14e-3 * 2, 1e-15);
  EXPECT_EQ(patch.reaction_n(0.001, -0.05, 0), 0);
}

TEST(Patch, RefusesConstantsThatAreNone) {
  EXPECT_THROW(VerticalPatch({.mass_kg = -1}), Error);
  EXPECT_THROW(VerticalPatch({.mass_kg = 0, .damping_n_s_per_m = 0}), Error);
  EXPECT_THROW(VerticalPatch({.contact_n_per_m = 0}), Error);
  EXPECT_THROW(VerticalPatch({.damping_n_s_per_m = NAN}), Error);
  EXPECT_THROW(KelvinVoigtPatch(0, 60, -75), Error);
}

}  // namespace
}  // namespace beatlas::palpation
