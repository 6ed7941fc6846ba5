#include "runtime/palpation/muscle.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "runtime/palpation/elastance.h"
#include "runtime/palpation/segments.h"

namespace beatlas::palpation {
namespace {

const MuscleTable kTable;

TEST(Muscle, TableOneIsAsPrinted) {
  EXPECT_EQ(kTable.base, (MuscleConstants{30.1, 766.5, 4.6, 90, 72}));
  EXPECT_EQ(kTable.middle, (MuscleConstants{164.8, 709.6, 2.1, 75, 60}));
  EXPECT_EQ(kTable.apex, (MuscleConstants{98.9, 655.4, 8.2, 45, 51}));
  EXPECT_NEAR(kTable.relaxation_rate_per_s(), 32.4, 0.05);
}

TEST(Muscle, BlendsInTheLogarithmBetweenItsAnchors) {
  EXPECT_EQ(blend(kTable, 0), kTable.apex);
  EXPECT_EQ(blend(kTable, 0.1), kTable.apex);
  EXPECT_EQ(blend(kTable, 0.5), kTable.middle);
  EXPECT_EQ(blend(kTable, 1), kTable.base);
  const MuscleConstants half = blend(kTable, 1.0 / 3);  // midway from apex to middle
  EXPECT_NEAR(half.k_v_n_per_m, std::sqrt(45.0 * 75.0), 1e-12 * 75);
  EXPECT_NEAR(half.c_h_n_s_per_m, std::sqrt(8.2 * 2.1), 1e-12 * 8.2);
  const MuscleConstants upper = blend(kTable, 0.75);  // three quarters from middle to base
  EXPECT_NEAR(upper.k_h1_n_per_m, std::pow(164.8, 0.25) * std::pow(30.1, 0.75), 1e-10);
}

TEST(Muscle, ThinScarIsSofterAndThickerIsStiffer) {
  const MuscleConstants infarct = in_tissue(kTable.middle, {.scar = 1, .thickness_ratio = 0.5});
  EXPECT_NEAR(infarct.k_v_n_per_m, 75 * 1.53 * 0.25, 1e-12 * 75);
  EXPECT_NEAR(infarct.k_h2_n_per_m, 709.6 * 1.53 * 0.5, 1e-12 * 710);
  EXPECT_NEAR(infarct.c_v_n_s_per_m / infarct.k_v_n_per_m, 0.8, 1e-12);
  EXPECT_EQ(in_tissue(kTable.middle, {}), kTable.middle);
  const MuscleConstants soft = in_tissue(kTable.middle, {.stiffness_ratio = 0.4});
  EXPECT_NEAR(soft.k_v_n_per_m, 0.4 * 75, 1e-12);
  EXPECT_NEAR(soft.k_h2_n_per_m, 0.4 * 709.6, 1e-9);
  EXPECT_NEAR(soft.c_v_n_s_per_m / soft.k_v_n_per_m, 60.0 / 75, 1e-12);
  EXPECT_NEAR(in_tissue(kTable.middle, {.thickness_ratio = 0.01}).k_v_n_per_m, 75 * 0.09,
              1e-12 * 75);
}

TEST(Muscle, ContractileStiffnessIsThatOfEquationSix) {
  // 1 mmHg/ml is 1.333e8 Pa/m^3.
  Contractile contractile;
  EXPECT_NEAR(contractile.stiffness_n_per_m(1, 7.3, 4.5), 7.3e-4 * 3e-4 * 4.5 * 1.33322e8, 1e-3);
  EXPECT_EQ(contractile.stiffness_n_per_m(0, 7.3, 4.5), 0);
  contractile.shortening_area_cm2 = 8.1;  // told, not of the beat
  EXPECT_NEAR(contractile.stiffness_n_per_m(1, 7.3, 4.5), 8.1e-4 * 3e-4 * 4.5 * 1.33322e8, 1e-3);
}

TEST(Muscle, ShorteningAreaIsTheMeanSectionOfTheCylinder) {
  // A cylinder of 50 ml is 34.1 mm wide and 54.6 mm long: as full throughout, its own section.
  EXPECT_NEAR(shortening_area_cm2(50, 50), M_PI / 4 * 3.414 * 3.414, 0.01);
  EXPECT_NEAR(shortening_area_cm2(40, 50), 0.8 * shortening_area_cm2(50, 50), 1e-12);
}

TEST(Muscle, PressureStiffensTheWallAsPiTimesPressureTimesRadius) {
  // 9 mmHg in 34.1 mm: 1200 Pa, 17.07 mm.
  EXPECT_NEAR(pressure_n_per_m(9, 50), M_PI * 1199.9 * 0.01707, 0.02);
  EXPECT_EQ(pressure_n_per_m(-3, 50), 0);
}

TEST(Muscle, HorizontalHasTheClosedStepAndRampResponse) {
  for (const MuscleConstants& place : {kTable.base, kTable.middle, kTable.apex}) {
    const double k1 = place.k_h1_n_per_m;
    const double rate = k1 / place.c_h_n_s_per_m;
    const double speed = 0.02;
    for (int parts : {1, 3, 1000}) {
      HorizontalMuscle muscle(k1, place.k_h2_n_per_m, place.c_h_n_s_per_m);
      const double ramp_s = 0.2;
      for (int n = 1; n <= parts; ++n) {
        muscle.relax(speed * ramp_s * n / parts, ramp_s / parts);
      }
      const double x = speed * ramp_s;
      const double q = place.c_h_n_s_per_m * speed * -std::expm1(-rate * ramp_s);
      EXPECT_NEAR(muscle.branch_n(), q, 1e-12 * q);
      EXPECT_NEAR(muscle.force_n(), -place.k_h2_n_per_m * x - q, 1e-12 * place.k_h2_n_per_m * x);
      // Equation (2): held, the branch lets go at K1 / C.
      muscle.relax(x, 0.05);
      EXPECT_NEAR(muscle.branch_n(), q * std::exp(-rate * 0.05), 1e-12 * q);
    }
  }
}

TEST(Muscle, ContractionHandsItsForceToTheSpringAndUnforcedEnergyFalls) {
  HorizontalMuscle muscle(164.8, 709.6, 2.1);
  const double contracted = muscle.contract(-0.003, 58);
  EXPECT_NEAR(contracted, 0.003 * (709.6 + 58), 1e-12);
  EXPECT_EQ(muscle.relax(-0.003, 0), contracted);
  double before = muscle.energy_j();
  for (int n = 0; n < 100; ++n) {
    muscle.relax(-0.003, 0.001);
    EXPECT_LT(muscle.energy_j(), before);
    before = muscle.energy_j();
  }
}

TEST(Muscle, SideOfTheCylinder) { EXPECT_NEAR(cylinder_of(50).side_area_cm2(), 58.6, 0.05); }

TEST(Elastance, ClosesAndHasAMaximumOfOne) {
  for (double period : {60.0 / 220, 0.4, 60.0 / 110, 0.75, 1.0, 2.0}) {
    const ElastanceCurve curve(period, kTable.relaxation_rate_per_s());
    EXPECT_NEAR(curve.at(0).value, 0, 1e-15);
    EXPECT_NEAR(curve.at(period).value, 0, 1e-12);
    double highest = 0;
    for (int n = 1; n < 4000; ++n) {
      const double t = period * n / 4000;
      highest = std::max(highest, curve.at(t).value);
      const double h = 1e-6 * period;  // the slope is the value's
      EXPECT_NEAR(curve.at(t).slope_per_s * period,
                  (curve.at(t + h).value - curve.at(t - h).value) / (2e-6), 2e-4);
      EXPECT_GE(curve.at(t).value, -1e-12);
    }
    EXPECT_NEAR(highest, 1, 1e-5);
    EXPECT_LE(highest, 1 + 1e-12);
  }
}

TEST(Elastance, RelaxesByEquationTwo) {
  const double rate = kTable.relaxation_rate_per_s();
  const ElastanceCurve curve(60.0 / 80, rate);
  const double from = curve.relaxes_from_s();
  EXPECT_GT(from, 0.3);
  EXPECT_LT(from, 0.5);
  // Second differences do not see the straight line that was taken off.
  const double h = 0.02;
  const auto bend = [&](double t) {
    return curve.at(t).value - 2 * curve.at(t + h).value + curve.at(t + 2 * h).value;
  };
  EXPECT_NEAR(bend(from + h) / bend(from), std::exp(-rate * h), 1e-12);
  EXPECT_NEAR(curve.at(from + 1e-9).slope_per_s, curve.at(from - 1e-9).slope_per_s, 1e-4);
}

TEST(Segments, AreNamedAndLieAroundTheAxis) {
  double share = 0;
  for (int segment = 1; segment <= kSegments; ++segment) {
    EXPECT_EQ(segment_from_name(segment_name(segment)), segment);
    share += segment_share(segment);
  }
  EXPECT_NEAR(share, 1, 1e-12);
  EXPECT_FALSE(segment_from_name("spleen"));
  const double third = std::numbers::pi / 3;
  for (int n = 0; n < 6; ++n) {
    EXPECT_EQ(segment_at(0.9, n * third), 1 + n);
    EXPECT_EQ(segment_at(0.5, (n - 6) * third + 0.4), 7 + n);
  }
  EXPECT_EQ(segment_at(0.2, 0), 13);
  EXPECT_EQ(segment_at(0.2, std::numbers::pi / 2), 14);
  EXPECT_EQ(segment_at(0.2, -std::numbers::pi / 2), 16);
  EXPECT_EQ(segment_at(0.01, 2), 17);
}

TEST(Segments, ThickeningTellsHowMuchContractionIsLeft) {
  EXPECT_EQ(alpha_of_thickening(0.57), 1);
  EXPECT_EQ(alpha_of_thickening(0.9), 1);
  EXPECT_EQ(alpha_of_thickening(-0.1), 0);
  EXPECT_NEAR(alpha_of_thickening(0.19), 1.0 / 3, 1e-12);
}

}  // namespace
}  // namespace beatlas::palpation
