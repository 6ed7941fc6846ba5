#include "runtime/palpation/oscillator.h"

#include <cmath>
#include <complex>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/palpation/muscle.h"

namespace beatlas::palpation::oscillator_tests {
namespace {

using Real = long double;
using Complex = std::complex<Real>;

constexpr double kExact = 1e-12;

// Particular solution and two exponentials, in long double; an implementation of its own.
std::pair<Real, Real> closed_form(Real m, Real c, Real k, Real y0, Real v0, Real f, Real r,
                                  Real t) {
  const Complex root = std::sqrt(Complex(c * c - 4 * k * m));
  const Complex s1 = -(c + root) / (2 * m);
  const Complex s2 = k / (m * s1);
  const Real p0 = (f - c * r / k) / k;
  const Real p1 = r / k;
  const Complex b = ((v0 - p1) - s1 * (y0 - p0)) / (s2 - s1);
  const Complex a = (y0 - p0) - b;
  const Complex e1 = a * std::exp(s1 * t);
  const Complex e2 = b * std::exp(s2 * t);
  return {p0 + p1 * t + (e1 + e2).real(), p1 + (s1 * e1 + s2 * e2).real()};
}

const MuscleTable kTable;
const std::vector<MuscleConstants> kPlaces{kTable.base, kTable.middle, kTable.apex};

TEST(Oscillator, WithoutMassHasTheClosedStepAndRampResponse) {
  for (const MuscleConstants& place : kPlaces) {
    const double k = place.k_v_n_per_m;
    const double c = place.c_v_n_s_per_m;
    for (double t : {1e-6, 1e-3, 0.02, 0.3, 5.0, 60.0}) {
      const OscillatorStep step({0, c, k}, t);
      const double rise = -std::expm1(-k / c * t);
      const double y = step.advance({}, 0.6, 0).place_m;
      EXPECT_NEAR(y, 0.6 / k * rise, kExact * y);
      const double ramp = step.advance({}, 0, 2).place_m;
      const Real slow = static_cast<Real>(c) / k;
      const Real closed = 2 / static_cast<Real>(k) * (t + slow * std::expm1(-t / slow));
      // What cancels in the closed form itself is not the step's error.
      EXPECT_NEAR(ramp, static_cast<double>(closed), kExact * ramp + 1e-19 * c / (k * k));
      EXPECT_NEAR(step.advance({0.008, 0}, 0, 0).place_m, 0.008 * std::exp(-k / c * t),
                  kExact * 0.008 * std::exp(-k / c * t));
    }
  }
}

TEST(Oscillator, HardCase11HasTheClosedFormOfEveryMass) {
  // 1 ug to 310 g, and springs up to 1e5 N/m: over- and underdamped.
  int complex_poles = 0;
  for (double m : {1e-9, 1e-6, 1.14e-3, 0.01, 0.045, 0.31}) {
    for (double c : {2.0, 51.0, 60.0, 72.0}) {
      for (double k : {1.0, 75.0, 881.0, 1e5}) {
        for (double t : {1e-3, 0.01, 0.1, 1.0}) {
          const auto [y, v] = closed_form(m, c, k, 0.004, -0.02, 0.3, 1.5, t);
          const Motion motion = OscillatorStep({m, c, k}, t).advance({0.004, -0.02}, 0.3, 1.5);
          const double size = std::abs(static_cast<double>(y));
          EXPECT_NEAR(motion.place_m, static_cast<double>(y), kExact * size)
              << m << " kg, " << c << " N s/m, " << k << " N/m, " << t << " s";
          // A speed is as good as the place is, a pole or a step apart.
          const double quick = std::max({std::abs(static_cast<double>(v)), size / t,
                                         size * std::sqrt(k / m) * (c * c < 4 * k * m)});
          EXPECT_NEAR(motion.speed_m_s, static_cast<double>(v), kExact * quick);
          complex_poles += c * c < 4 * k * m ? 1 : 0;
        }
      }
    }
  }
  EXPECT_GT(complex_poles, 20);
}

TEST(Oscillator, WithoutSpringOrDamperIsTheOneThatIsLeft) {
  const Motion coasting = OscillatorStep({0.1, 0, 0}, 0.5).advance({1, 2}, 3, 4);
  EXPECT_NEAR(coasting.place_m, 1 + 2 * 0.5 + 0.5 * 30 * 0.25 + 40 * 0.125 / 6, 1e-12);
  EXPECT_NEAR(coasting.speed_m_s, 2 + 15 + 20 * 0.25, 1e-12);
  const Motion ringing = OscillatorStep({0.1, 0, 40}, 0.5).advance({1, 0}, 0, 0);
  EXPECT_NEAR(ringing.place_m, std::cos(10.0), 1e-12);
  const Motion dragged = OscillatorStep({0.1, 2, 0}, 0.5).advance({0, 1}, 0, 0);
  EXPECT_NEAR(dragged.place_m, 0.05 * -std::expm1(-10.0), 1e-13);
}

TEST(Oscillator, GoesToTheLimitOfNoMass) {
  // The place differs by m / c^2 of what is left: to first order in the mass.
  const double t = 0.02;
  const double limit = OscillatorStep({0, 60, 75}, t).advance({0.008, 0}, 0, 0).place_m;
  double before = 1;
  for (double m : {1e-3, 1e-5, 1e-7, 1e-9}) {
    const double off =
        std::abs(OscillatorStep({m, 60, 75}, t).advance({0.008, 0}, 0, 0).place_m - limit);
    EXPECT_LT(off, 0.02 * before);
    before = off;
  }
  EXPECT_LT(before, 1e-12);
}

TEST(Oscillator, HardCase11GivesTheSameSamplesForStepsOfAnyLength) {
  // The force is straight between corners 100 ms apart; samples at the corners.
  const std::vector<double> corners{0, 0.6, 0.4, -0.3, 0.9, 0.9, 0};
  for (double m : {0.0, 1e-9, 1.14e-3, 0.31}) {
    std::vector<double> whole;
    for (int parts : {1, 2, 7, 100, 1000}) {
      const OscillatorStep step({m, 60, 75}, 0.1 / parts);
      Motion motion;
      std::vector<double> samples;
      for (std::size_t n = 1; n < corners.size(); ++n) {
        const double rate = (corners[n] - corners[n - 1]) / 0.1;
        for (int part = 0; part < parts; ++part) {
          motion = step.advance(motion, corners[n - 1] + rate * 0.1 * part / parts, rate);
        }
        samples.push_back(motion.place_m);
      }
      if (parts == 1) whole = samples;
      for (std::size_t n = 0; n < samples.size(); ++n) {
        EXPECT_NEAR(samples[n], whole[n], kExact * 0.01) << m << " kg in " << parts << " parts";
      }
    }
  }
}

TEST(Oscillator, HardCase11UnforcedNeverGainsEnergy) {
  for (double m : {0.0, 1e-9, 1e-5, 1.14e-3, 0.045, 0.31}) {
    for (double c : {0.01, 1.0, 60.0}) {
      for (double k : {0.0, 1.0, 75.0, 881.0, 1e5}) {
        for (double h : {1e-6, 1e-4, 1e-3, 0.02, 1.0}) {
          const OscillatorStep step({m, c, k}, h);
          Motion motion{0.01, m > 0 ? -0.3 : 0.0};
          const auto energy = [&] {
            return 0.5 *
                   (m * motion.speed_m_s * motion.speed_m_s + k * motion.place_m * motion.place_m);
          };
          double before = energy();
          const double start = before;
          for (int n = 0; n < 300; ++n) {
            motion = step.advance(motion, 0, 0);
            const double now = energy();
            ASSERT_LE(now, before * (1 + 1e-13) + 1e-30 * start) << m << ' ' << c << ' ' << k;
            before = now;
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace beatlas::palpation::oscillator_tests
