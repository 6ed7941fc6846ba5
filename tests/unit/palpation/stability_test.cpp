// The circulation at the ends of its parameters: no number that is none, no negative volume, and
// all energy accounted for.

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "runtime/palpation/circulation.h"

namespace beatlas::palpation {
namespace {

struct Worst {
  double least_ml = INFINITY;
  double residual = 0;  // of what was turned over
  bool finite = true;
  bool backwards = false;  // flow through a valve
  double most_ml = 0;
};

Worst run(const CirculationParameters& p, double step_s, double seconds) {
  Circulation circulation(p);
  Worst worst;
  const int ticks = static_cast<int>(seconds / step_s);
  for (int tick = 0; tick < ticks; ++tick) {
    // 10 mm within a step, held for 0.3 s, let go within a step.
    const bool pressed = static_cast<int>(tick * step_s / 0.3) % 2 == 1;
    circulation.tick(step_s, pressed ? 0.01 : -0.02);
    const double v = circulation.volume_ml();
    worst.finite = worst.finite && std::isfinite(v) && std::isfinite(circulation.lv_mmhg()) &&
                   std::isfinite(circulation.aortic_mmhg()) &&
                   std::isfinite(circulation.finger_n());
    worst.least_ml = std::min(worst.least_ml, v);
    worst.most_ml = std::max(worst.most_ml, v);
    worst.backwards = worst.backwards || circulation.mitral_flow_ml_s() < 0 ||
                      circulation.aortic_flow_ml_s() < 0 || circulation.finger_n() < 0;
  }
  const Ledger& ledger = circulation.ledger();
  worst.residual = std::abs(ledger.residual_j()) / ledger.turned_over_j;
  return worst;
}

TEST(Stability, AtEveryCornerOfWhatCanBeAdjusted) {
  for (double rate : {30.0, 220.0}) {
    for (double left : {0.0, 40.0}) {
      for (double contractility : {0.1, 3.0}) {
        for (double infarct : {0.0, 1.0}) {
          for (double weight : {1.0, 25.0, 200.0}) {
            for (Contact contact : {Contact::Kinematic, Contact::Viscoelastic}) {
              CirculationParameters p = at_weight({}, weight);
              p.heart_rate_per_min = rate;
              p.left_atrial_mmhg = left;
              p.contractility = contractility;
              p.infarct_fraction = infarct;
              p.contact = contact;
              const Worst worst = run(p, 1e-3, 6);
              EXPECT_TRUE(worst.finite);
              EXPECT_GE(worst.least_ml, 0);
              EXPECT_FALSE(worst.backwards);
              EXPECT_LT(worst.residual, 5e-3)
                  << rate << ' ' << left << ' ' << contractility << ' ' << infarct << ' ' << weight;
            }
          }
        }
      }
    }
  }
}

TEST(Stability, AtAnyParametersInRange) {
  std::mt19937 random(17);
  const auto any = [&](double low, double high) {  // even in the logarithm
    return low * std::pow(high / low, std::uniform_real_distribution<double>(0, 1)(random));
  };
  for (int draw = 0; draw < 300; ++draw) {
    CirculationParameters p;
    p.heart_rate_per_min = any(30, 220);
    p.left_atrial_mmhg = any(0.01, 40);
    p.right_atrial_mmhg = any(0.01, 40);
    p.resistance = any(1e-3, 1e3);
    p.impedance = any(1e-4, 1e2);
    p.compliance = any(1e-3, 1e2);
    p.aortic_valve = any(1e-4, 1);  // with a stiff ventricle a valve closes within a tick
    p.mitral_valve = any(1e-4, 1);
    p.emin = any(1e-4, 10);
    p.emax = p.emin * any(1, 100);
    p.branch_elastance = p.emin * any(0.01, 100);
    p.v0_ml = any(0.01, 40);
    p.reference_volume_ml = p.v0_ml * any(1, 100);
    p.relaxation_rate_per_s = any(1, 1e3);
    p.contractility = any(0.1, 3);
    p.contact_area_cm2 = any(0.1, 1e3);
    p.stop_n_per_m = any(1, 1e6);
    p.finger_k_n_per_m = any(1e-3, 1e5);
    p.finger_c_n_s_per_m = any(1e-3, 1e5);
    p.contact = draw % 2 == 0 ? Contact::Kinematic : Contact::Viscoelastic;
    const Worst worst = run(p, draw % 3 == 0 ? 5e-3 : 1e-3, 3);
    EXPECT_TRUE(worst.finite) << draw;
    EXPECT_GE(worst.least_ml, 0) << draw;
    EXPECT_FALSE(worst.backwards) << draw;
  }
}

TEST(Stability, DepthsAndStepsThatAreNone) {
  Circulation circulation({});
  circulation.tick(NAN, 0.01);
  circulation.tick(-1, 0.01);
  circulation.tick(0, 0.01);
  circulation.tick(10, 0.01);
  EXPECT_EQ(circulation.volume_ml(), 49.8);
  for (double depth : {static_cast<double>(NAN), -static_cast<double>(INFINITY),
                       static_cast<double>(INFINITY), 1e9}) {
    for (int n = 0; n < 2000; ++n) circulation.tick(1e-3, depth);
    EXPECT_TRUE(std::isfinite(circulation.volume_ml()));
    EXPECT_GE(circulation.volume_ml(), 0);
  }
  while (circulation.phase() < 0.99) circulation.tick(1e-3, -1);
  for (int n = 0; n < 20000; ++n) circulation.tick(1e-3, -1);
  EXPECT_NEAR(circulation.last_beat().stroke_ml, 20.4, 0.2);  // and it is well again
}

}  // namespace
}  // namespace beatlas::palpation
