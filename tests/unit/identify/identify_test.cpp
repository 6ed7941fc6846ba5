#include "pipeline/identify/identify.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "runtime/palpation/muscle.h"

namespace beatlas::identify {
namespace {

using palpation::MuscleConstants;

const palpation::MuscleTable kTable;
constexpr double kNoise = 0.01;  // of the range of what is measured

double half_cosine(double t, double start, double length) {
  return 0.5 * (1 - std::cos(std::numbers::pi * std::clamp((t - start) / length, 0.0, 1.0)));
}

void add_noise(std::vector<double>& values, double share, unsigned seed) {
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, share * (*most - *least));
  if (share == 0) return;
  for (double& value : values) value += noise(random);
}

// Equation (3) by Runge-Kutta 4 at 20 us: no code of what is tested.
Recording relaxation(const MuscleConstants& m, double share, unsigned seed) {
  const auto stretch = [](double t) { return 3.5e-3 * half_cosine(t, 0.02, 0.12); };
  const auto rate = [&](double t, double q) {
    return m.k_h1_n_per_m * (stretch(t + 1e-7) - stretch(t - 1e-7)) / 2e-7 -
           m.k_h1_n_per_m / m.c_h_n_s_per_m * q;
  };
  Recording out;
  double q = 0.5;
  constexpr double h = 2e-5;
  for (int n = 0; n <= 600; ++n) {
    const double t = 1e-3 * n;
    out.time_s.push_back(t);
    out.position_m.push_back(stretch(t));
    out.force_n.push_back(m.k_h2_n_per_m * stretch(t) + q + 0.2);
    for (int part = 0; part < 50; ++part) {
      const double at = t + h * part;
      const double a = rate(at, q);
      const double b = rate(at + h / 2, q + h / 2 * a);
      const double c = rate(at + h / 2, q + h / 2 * b);
      q += h / 6 * (a + 2 * b + 2 * c + rate(at + h, q + h * c));
    }
  }
  add_noise(out.force_n, share, seed);
  return out;
}

Recording press(const MuscleConstants& m, double share, unsigned seed) {
  const auto force = [](double t) {
    return 0.6 * (half_cosine(t, 0.1, 0.2) - half_cosine(t, 1.5, 0.1));
  };
  Recording out;
  double y = 0;
  constexpr double h = 1e-4;
  for (int n = 0; n <= 800; ++n) {
    const double t = 5e-3 * n;
    out.time_s.push_back(t);
    out.position_m.push_back(y);
    out.force_n.push_back(force(t));
    for (int part = 0; part < 50; ++part) {  // implicit midpoint
      const double middle = force(t + h * (part + 0.5));
      const double kept = m.c_v_n_s_per_m - 0.5 * h * m.k_v_n_per_m;
      y = (kept * y + h * middle) / (m.c_v_n_s_per_m + 0.5 * h * m.k_v_n_per_m);
    }
  }
  add_noise(out.position_m, share, seed);
  return out;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

struct Draws {
  std::vector<double> k1, k2, c;
  double inside = 0;  // share of intervals that hold the true k_h1
  double widest = 0;  // interval of k_h1 over its value
};

Draws draw(const MuscleConstants& m, int count) {
  Draws out;
  for (int n = 0; n < count; ++n) {
    const HorizontalFit fit =
        identify_horizontal(relaxation(m, kNoise, 100U + static_cast<unsigned>(n)));
    out.k1.push_back(fit.k_h1_n_per_m.value);
    out.k2.push_back(fit.k_h2_n_per_m.value);
    out.c.push_back(fit.c_h_n_s_per_m.value);
    const Estimate& k1 = fit.k_h1_n_per_m;
    if (k1.low <= m.k_h1_n_per_m && m.k_h1_n_per_m <= k1.high) out.inside += 1.0 / count;
    out.widest = std::max(out.widest, (k1.high - k1.low) / m.k_h1_n_per_m);
  }
  return out;
}

TEST(Identify, ExactRecordingsGiveTheConstantsBack) {
  for (const MuscleConstants& m : {kTable.base, kTable.middle, kTable.apex}) {
    const HorizontalFit fit = identify_horizontal(relaxation(m, 0, 0));
    // Straight lines between samples of a smooth stretch: 1e-4 of it.
    EXPECT_NEAR(fit.k_h1_n_per_m.value, m.k_h1_n_per_m, 2e-3 * m.k_h1_n_per_m);
    EXPECT_NEAR(fit.k_h2_n_per_m.value, m.k_h2_n_per_m, 1e-4 * m.k_h2_n_per_m);
    EXPECT_NEAR(fit.c_h_n_s_per_m.value, m.c_h_n_s_per_m, 2e-3 * m.c_h_n_s_per_m);
    EXPECT_NEAR(fit.asymptote_n, 0.2, 1e-3);
    const VerticalFit vertical = identify_vertical(press(m, 0, 0));
    EXPECT_NEAR(vertical.k_v_n_per_m.value, m.k_v_n_per_m, 1e-3 * m.k_v_n_per_m);
    EXPECT_NEAR(vertical.c_v_n_s_per_m.value, m.c_v_n_s_per_m, 1e-3 * m.c_v_n_s_per_m);
  }
}

TEST(Identify, MiddleAndApexComeBackFromNoiseInTheMedian) {
  for (const MuscleConstants& m : {kTable.middle, kTable.apex}) {
    const Draws draws = draw(m, 41);
    EXPECT_NEAR(median(draws.k1), m.k_h1_n_per_m, 0.02 * m.k_h1_n_per_m);
    EXPECT_NEAR(median(draws.k2), m.k_h2_n_per_m, 0.02 * m.k_h2_n_per_m);
    EXPECT_NEAR(median(draws.c), m.c_h_n_s_per_m, 0.02 * m.c_h_n_s_per_m);
    EXPECT_GE(draws.inside, 0.85);  // of 95 % intervals, in 41 draws
    EXPECT_LT(draws.widest, 0.6);
  }
}

TEST(Identify, TheBaseIsToldWithItsWideInterval) {
  const Draws base = draw(kTable.base, 41);
  const Draws middle = draw(kTable.middle, 11);
  EXPECT_GE(base.inside, 0.85);
  EXPECT_GT(base.widest, 2 * middle.widest);
  EXPECT_NEAR(median(base.k2), kTable.base.k_h2_n_per_m, 0.02 * kTable.base.k_h2_n_per_m);
}

TEST(Identify, APressComesBackFromNoise) {
  for (const MuscleConstants& m : {kTable.base, kTable.middle, kTable.apex}) {
    const std::vector<double> quiet = press(m, 0, 0).position_m;
    const double range = *std::max_element(quiet.begin(), quiet.end());
    std::vector<double> k;
    std::vector<double> c;
    int inside = 0;
    for (unsigned n = 0; n < 21; ++n) {
      const VerticalFit fit = identify_vertical(press(m, kNoise, n));
      k.push_back(fit.k_v_n_per_m.value);
      c.push_back(fit.c_v_n_s_per_m.value);
      inside += fit.k_v_n_per_m.low <= m.k_v_n_per_m && m.k_v_n_per_m <= fit.k_v_n_per_m.high;
      EXPECT_NEAR(fit.rms_m, kNoise * range, 0.15 * kNoise * range);  // what is left is the noise
    }
    EXPECT_NEAR(median(k), m.k_v_n_per_m, 0.02 * m.k_v_n_per_m);
    EXPECT_NEAR(median(c), m.c_v_n_s_per_m, 0.02 * m.c_v_n_s_per_m);
    EXPECT_GE(inside, 17);
  }
}

TEST(Identify, RefusesWhatHoldsNothing) {
  Recording sound = relaxation(kTable.middle, 0, 0);
  Recording still = sound;
  std::fill(still.position_m.begin(), still.position_m.end(), 0.001);
  EXPECT_THROW((void)identify_horizontal(still), Error);
  Recording backwards = sound;
  std::swap(backwards.time_s[5], backwards.time_s[6]);
  EXPECT_THROW((void)identify_horizontal(backwards), Error);
  Recording other = sound;
  for (double& force : other.force_n) force = -force;
  EXPECT_THROW((void)identify_horizontal(other), Error);
  Recording few = sound;
  few.time_s.resize(10);
  EXPECT_THROW((void)identify_horizontal(few), Error);
  Recording gap = sound;
  gap.force_n[3] = NAN;
  EXPECT_THROW((void)identify_vertical(gap), Error);
}

}  // namespace
}  // namespace beatlas::identify
