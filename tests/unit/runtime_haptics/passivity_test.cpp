// Hard case 13: a mass that an operator shakes against a wall rendered with sampling, delay and
// damping gives the operator no energy (Colgate and Schenkel 1997, with delay).

#include <algorithm>
#include <cmath>
#include <deque>
#include <random>

#include <gtest/gtest.h>

#include "runtime/haptics/proxy.h"
#include "tests/unit/runtime_haptics/closed_forms.h"

namespace beatlas::haptics {
namespace {

struct Loop {
  double stiffness;  // K [N/m]
  double damping;    // B: C of the model's damper [N s/m]
  double period_s;   // T
  int delay_ticks;   // of the force, beside the sample and hold
  double viscous;    // b of the device [N s/m]
};

// A phase of a beating sphere of 20 mm, held.
std::shared_ptr<const ContactField> held_sphere() {
  static const auto field =
      testing::packed({.origin_mm = Vec3::Constant(-30), .blocks = {5, 5, 5}, .phases = 4},
                      [](const Vec3& x, double t) { return x.norm() - 20 - 4 * t; });
  return field;
}

// Largest energy [J] that device and wall together ever gave to the operator, who pushes the mass
// with random forces along a radius. The mass is integrated exactly between ticks, forces held.
double generated_j(const Loop& loop, std::uint32_t seed) {
  constexpr double kMass = 0.05;
  ProxyModel model(held_sphere(),
                   {.stiffness_n_per_m = loop.stiffness, .damping_n_s_per_m = loop.damping});
  std::mt19937 random(seed);
  std::normal_distribution<double> push(-0.3, 1.5);
  std::deque<double> sent(static_cast<std::size_t>(loop.delay_ticks), 0.0);
  const Vec3 direction = Vec3(2, -1, 2) / 3;
  double x = 1e-4;  // [m] above 20 mm
  double v = 0;
  double hand = 0;
  double given = 0;
  double worst = 0;
  const double decay = std::exp(-loop.viscous / kMass * loop.period_s);
  for (int n = 0; n < 20000; ++n) {
    const Contact contact =
        model.evaluate((20 + 1e3 * x) * direction, 0, n == 0 ? 0 : loop.period_s);
    sent.push_back(contact.force_n.dot(direction));
    const double wall = sent.front();
    sent.pop_front();
    // Bursts, and quiet times in which a limit cycle would show; a weak pull that keeps it in
    // touch.
    if (n % 40 == 0) hand = n / 2000 % 2 == 0 ? push(random) : -0.2;
    if (x > 0.003) hand = -1;
    const double steady = (wall + hand) / loop.viscous;
    const double moved = steady * loop.period_s + (v - steady) * kMass / loop.viscous * (1 - decay);
    v = steady + (v - steady) * decay;
    x += moved;
    given -= hand * moved;  // work on the operator
    worst = std::max(worst, given);
  }
  return worst;
}

double colgate_schenkel(const Loop& loop) {
  return loop.stiffness * loop.period_s * (0.5 + loop.delay_ticks) + std::abs(loop.damping);
}

TEST(HardCase13, NoEnergyComesOfAWallWhereverTheDevicesFrictionIsEnough) {
  std::uint32_t seed = 0;
  for (double stiffness : {50.0, 150.0, 600.0, 2000.0}) {
    for (double damping : {0.0, 0.5, 3.0}) {
      for (double period_s : {0.0005, 0.001, 0.002}) {
        for (int delay : {0, 1, 3}) {
          Loop loop{stiffness, damping, period_s, delay, 0};
          loop.viscous = 1.05 * colgate_schenkel(loop);
          // Of forces of some N and ways of some mm: what the field's 0.002 mm are good for.
          EXPECT_LE(generated_j(loop, ++seed), 1e-6)
              << stiffness << ' ' << damping << ' ' << period_s << ' ' << delay;
        }
      }
    }
  }
}

TEST(HardCase13, TheModelsDamperAsksForLessFrictionThanAVelocityWould) {
  // Its branch is a spring k at most: b > (K + k) (T/2 + t_d), whatever C.
  for (double damping : {5.0, 50.0}) {
    for (int delay : {0, 1}) {
      Loop loop{150, damping, 0.001, delay, 0};
      loop.viscous = 1.05 * (150 + 500) * 0.001 * (0.5 + delay);
      EXPECT_LT(loop.viscous, colgate_schenkel(loop));
      EXPECT_LE(generated_j(loop, 7), 1e-6) << damping << ' ' << delay;
    }
  }
}

TEST(HardCase13, WithTooLittleFrictionEnergyIsGeneratedAndSeen) {
  Loop loop{2000, 0, 0.001, 3, 0};
  loop.viscous = 0.2 * colgate_schenkel(loop);
  EXPECT_GT(generated_j(loop, 1), 1e-4);
}

}  // namespace
}  // namespace beatlas::haptics
