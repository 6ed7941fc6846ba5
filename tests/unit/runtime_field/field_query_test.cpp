#include "runtime/field/field_query.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "tests/unit/runtime_field/test_fields.h"

namespace beatlas::field {
namespace {

using atlas::FieldPayload;
using ::beatlas::testing::dense_payload;
using ::beatlas::testing::LatticeSpec;

constexpr double kPi = std::numbers::pi;

// --- An evaluation of the payload's formula as it is written in payloads.h: double, no shortcut.

double b3(double u) {
  const double a = std::abs(u);
  if (a < 1) return 2.0 / 3 - a * a + a * a * a / 2;
  return a < 2 ? (2 - a) * (2 - a) * (2 - a) / 6 : 0;
}
double b3_slope(double u) {
  const double a = std::abs(u);
  const double sign = u < 0 ? -1 : 1;
  if (a < 1) return sign * (-2 * a + 1.5 * a * a);
  return a < 2 ? -sign * (2 - a) * (2 - a) / 2 : 0;
}

double coefficient(const FieldPayload& field, int i, int j, int k, int phase) {
  const int bx = i >> 3, by = j >> 3, bz = k >> 3;
  // Any count beyond the clamp will do; the answer is clamped.
  const double outside = field.clamp_count(false);
  const double inside = field.clamp_count(true);
  if (bx < 0 || by < 0 || bz < 0 || bx >= field.block_count[0] || by >= field.block_count[1] ||
      bz >= field.block_count[2]) {
    return outside;
  }
  const int entry = field.blocks[static_cast<std::size_t>(
      bx + field.block_count[0] * (by + field.block_count[1] * bz))];
  if (entry == FieldPayload::kOutside) return outside;
  if (entry == FieldPayload::kInside) return inside;
  const int sample = ((entry * 8 + (k & 7)) * 8 + (j & 7)) * field.phases * 8 + (i & 7);
  return field.coefficients[static_cast<std::size_t>(sample + 8 * phase)];
}

struct Reference {
  double value = 0;
  Vec3 gradient = Vec3::Zero();
  double rate = 0;
};

Reference evaluate(const FieldPayload& field, double rr, const Vec3& x, double t) {
  const Vec3 g = (x - field.origin_mm) / field.voxel_mm;
  const double s = t / rr * field.phases;
  Reference out;
  for (int k = int(std::floor(g[2])) - 1; k <= int(std::floor(g[2])) + 2; ++k) {
    for (int j = int(std::floor(g[1])) - 1; j <= int(std::floor(g[1])) + 2; ++j) {
      for (int i = int(std::floor(g[0])) - 1; i <= int(std::floor(g[0])) + 2; ++i) {
        for (int n = int(std::floor(s)) - 1; n <= int(std::floor(s)) + 2; ++n) {
          const int phase = ((n % field.phases) + field.phases) % field.phases;
          const double c = field.step_mm * coefficient(field, i, j, k, phase);
          const double wx = b3(g[0] - i), wy = b3(g[1] - j), wz = b3(g[2] - k), wt = b3(s - n);
          out.value += c * wx * wy * wz * wt;
          out.gradient += c * wt / field.voxel_mm *
                          Vec3(b3_slope(g[0] - i) * wy * wz, wx * b3_slope(g[1] - j) * wz,
                               wx * wy * b3_slope(g[2] - k));
          out.rate += c * wx * wy * wz * b3_slope(s - n) * field.phases / rr;
        }
      }
    }
  }
  return out;
}

// Random blocks of all three kinds, random coefficients.
std::shared_ptr<FieldPayload> random_payload(int phases, unsigned seed) {
  std::mt19937 random(seed);
  auto field = std::make_shared<FieldPayload>();
  field->origin_mm = Vec3(-7.3, 11.1, 3.9);
  field->voxel_mm = 1.3;
  field->block_count = {3, 2, 4};
  field->phases = phases;
  field->step_mm = 0.01;
  field->inner_mm = 4.5;
  field->outer_mm = 6;
  std::uniform_int_distribution<int> kind(0, 5);
  std::uniform_int_distribution<int> count(-700, 700);  // may leave the clamp: -7..7 mm
  std::int32_t leaves = 0;
  for (int b = 0; b < 3 * 2 * 4; ++b) {
    const int k = kind(random);
    if (k < 2) {
      field->blocks.push_back(k == 0 ? FieldPayload::kOutside : FieldPayload::kInside);
      continue;
    }
    field->blocks.push_back(leaves++);
    for (int n = 0; n < FieldPayload::kBlockSamples * phases; ++n) {
      field->coefficients.push_back(static_cast<std::int16_t>(count(random)));
    }
  }
  return field;
}

TEST(FieldQuery, EqualsThePayloadsFormulaForAnyBlocksAndNumberOfPhases) {
  for (int phases : {1, 2, 3, 4, 5, 15, 30}) {
    const auto field = random_payload(phases, 100U + static_cast<unsigned>(phases));
    const double rr = 0.83;
    const FieldQuery query(field, rr);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> u(0, 1);
    int compared = 0;
    for (int n = 0; n < 4000; ++n) {
      const Vec3 x = field->origin_mm +
                     1.3 * Vec3(-4 + 32 * u(random), -4 + 24 * u(random), -4 + 40 * u(random));
      const double t = -2 + 4 * u(random);
      const Reference expected = evaluate(*field, rr, x, t);
      const FieldSample found = query.sample(x, t);
      // Float sums of 64 terms up to 700 counts of 0.01 mm.
      constexpr double kRounding = 2e-5;
      if (expected.value <= -4.5 + kRounding || expected.value >= 6 - kRounding) {
        EXPECT_NEAR(found.distance_mm, expected.value < 0 ? -4.5 : 6, kRounding);
        continue;
      }
      ++compared;
      ASSERT_NEAR(found.distance_mm, expected.value, kRounding) << phases << " phases";
      ASSERT_LT((found.gradient - expected.gradient).norm(), kRounding);
      ASSERT_NEAR(found.rate_mm_s, expected.rate, kRounding * phases * 2);
    }
    EXPECT_GT(compared, 1500);
  }
}

TEST(FieldQuery, GradientAndRateAreTheDerivativesOfTheDistance) {
  const LatticeSpec spec{.origin_mm = Vec3(-20, -20, -20)};
  const auto phi = [](const Vec3& x, double t) {
    return x.norm() - 15 - 2 * std::sin(2 * kPi * t / 0.75);
  };
  const FieldQuery query(dense_payload(spec, phi), 0.75);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(-12, 12);
  for (int n = 0; n < 500; ++n) {
    const Vec3 x(u(random), u(random), u(random));
    const double t = u(random);
    const FieldSample here = query.sample(x, t);
    // Central differences: truncation h^2/6 of the third derivative, rounding 1e-5 mm / (2 h).
    constexpr double h = 0.02;
    for (int a = 0; a < 3; ++a) {
      const Vec3 e = h * Vec3::Unit(a);
      const double slope =
          (query.sample(x + e, t).distance_mm - query.sample(x - e, t).distance_mm) / (2 * h);
      EXPECT_NEAR(here.gradient[a], slope, 2e-3);
    }
    constexpr double ht = 1e-3;
    const double rate =
        (query.sample(x, t + ht).distance_mm - query.sample(x, t - ht).distance_mm) / (2 * ht);
    EXPECT_NEAR(here.rate_mm_s, rate, 0.03);  // of up to 16.8 mm/s
  }
}

TEST(FieldQuery, MicrometreStepsOverCellFacesAreSmooth) {
  // Hard case 6: 1 um steps over 1e5 faces; <= 1.05 um (Lipschitz) and <= 0.005 deg.
  const Vec3 axes(15, 12, 18);
  const LatticeSpec spec{.origin_mm = Vec3(-24, -24, -24),
                         .voxel_mm = 1,
                         .blocks = {6, 6, 6},
                         .phases = 1,
                         .step_mm = 0.01};
  const FieldQuery query(
      dense_payload(spec, [&](const Vec3& x,
                              double) { return beatlas::testing::ellipsoid_distance(axes, x); }),
      1);
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::uniform_int_distribution<int> axis(0, 2);
  std::uniform_real_distribution<double> depth(-3, 3);
  double worst_step = 0;
  double worst_turn_deg = 0;
  for (int n = 0; n < 100000; ++n) {
    const Vec3 direction = Vec3(normal(random), normal(random), normal(random)).normalized();
    Vec3 x = direction * (1 / direction.cwiseQuotient(axes).norm() + depth(random));
    const int a = axis(random);
    x[a] = std::round(x[a]);  // onto a face
    const Vec3 half = 0.0005 * direction;
    const FieldSample before = query.sample(x - half, 0);
    const FieldSample after = query.sample(x + half, 0);
    ASSERT_TRUE(before.in_band && after.in_band);
    worst_step = std::max(worst_step, std::abs(after.distance_mm - before.distance_mm));
    const double sine = before.gradient.normalized().cross(after.gradient.normalized()).norm();
    worst_turn_deg = std::max(worst_turn_deg, std::asin(sine) * 180 / kPi);
  }
  RecordProperty("worst_step_nm", static_cast<int>(worst_step * 1e6));
  RecordProperty("worst_turn_udeg", static_cast<int>(worst_turn_deg * 1e6));
  EXPECT_GE(worst_step, 0.95e-3);
  EXPECT_LE(worst_step, 1.05e-3);
  EXPECT_LE(worst_turn_deg, 0.005);
}

TEST(FieldQuery, TheCycleClosesWithoutAStep) {
  // Hard case 8: in contact, the largest change a tick at the wrap is that of mid-cycle.
  const LatticeSpec spec{.origin_mm = Vec3(-20, -20, -20)};
  const auto phi = [](const Vec3& x, double t) {
    return x.norm() - 15 - 2 * std::sin(2 * kPi * t / 0.75);
  };
  const FieldQuery query(dense_payload(spec, phi), 0.75);
  const Vec3 x(10, 3, -5);
  const auto largest_step = [&](double from, double to) {
    double largest = 0;
    for (double t = from; t < to; t += 0.001) {
      largest = std::max(largest, std::abs(query.sample(x, t + 0.001).distance_mm -
                                           query.sample(x, t).distance_mm));
    }
    return largest;
  };
  // The sine's slope at the wrap is +, at mid-cycle -, of the same size.
  EXPECT_LE(largest_step(0.70, 0.80), 1.1 * largest_step(0.325, 0.425));
  const FieldSample first = query.sample(x, 0.1);
  for (double beats : {-3.0, 1.0, 1000.0}) {
    const FieldSample later = query.sample(x, 0.1 + beats * 0.75);
    EXPECT_NEAR(later.distance_mm, first.distance_mm, 1e-5);
    EXPECT_NEAR(later.rate_mm_s, first.rate_mm_s, 1e-3);
  }
  // From below, t may round to a whole beat.
  EXPECT_NEAR(query.sample(x, std::nextafter(0.75, 0)).distance_mm, query.sample(x, 0).distance_mm,
              1e-5);
  EXPECT_NEAR(query.sample(x, -1e-18).distance_mm, query.sample(x, 0).distance_mm, 1e-5);
}

TEST(FieldQuery, SignsAreRightFarAway) {
  auto field = std::make_shared<FieldPayload>();
  field->voxel_mm = 2;
  field->block_count = {3, 3, 3};
  field->phases = 4;
  field->step_mm = 0.01;
  field->inner_mm = 15;
  field->outer_mm = 6;
  field->blocks.assign(27, FieldPayload::kOutside);
  field->blocks[13] = FieldPayload::kInside;
  const FieldQuery query(field, 1);
  const FieldSample middle = query.sample(Vec3(23, 23, 23), 0.3);
  EXPECT_DOUBLE_EQ(middle.distance_mm, -15);
  EXPECT_FALSE(middle.in_band);
  EXPECT_TRUE(middle.gradient.isZero());
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const Vec3& x : {Vec3(1, 1, 1), Vec3(-1e9, 0, 0), Vec3(0, 1e300, 0), Vec3(23, 23, -4.01),
                        Vec3(kNan, 23, 23), Vec3(23, kInfinity, 23)}) {
    const FieldSample far = query.sample(x, 0.3);
    EXPECT_DOUBLE_EQ(far.distance_mm, 6);
    EXPECT_TRUE(far.gradient.isZero());
    EXPECT_EQ(far.rate_mm_s, 0);
    EXPECT_FALSE(far.in_band);
  }
  EXPECT_DOUBLE_EQ(query.sample(Vec3(23, 23, 23), kNan).distance_mm, 6);
  EXPECT_DOUBLE_EQ(query.sample(Vec3(23, 23, 23), kInfinity).distance_mm, 6);

  // Away from the band a normal points away from the centre, the middle of the inside block.
  EXPECT_LT((query.centre_mm() - Vec3(23, 23, 23)).norm(), 1e-12);
  EXPECT_LT(
      (query.normal(query.sample(Vec3(23, 23, 99), 0), Vec3(23, 23, 99)) - Vec3(0, 0, 1)).norm(),
      1e-12);
  EXPECT_TRUE(query.normal(middle, query.centre_mm()).isZero());
}

TEST(FieldQuery, MovesWithABeatingSphere) {
  // Radius 15 +- 2 mm; spline through 15 phases of a sine is right to (2 pi / 15)^4 / 720 of 2 mm.
  const LatticeSpec spec{
      .origin_mm = Vec3(-20.2, -20.7, -20.4), .voxel_mm = 1, .blocks = {6, 6, 6}};
  const auto radius = [](double t) { return 15 + 2 * std::sin(2 * kPi * t / 0.75); };
  const FieldQuery query(
      dense_payload(spec, [&](const Vec3& x, double t) { return x.norm() - radius(t); }), 0.75);
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> u(-3, 3);
  for (int n = 0; n < 3000; ++n) {
    const Vec3 direction = Vec3(normal(random), normal(random), normal(random)).normalized();
    const double t = u(random);
    const Vec3 x = direction * (radius(t) + std::abs(u(random)) * -1);
    const FieldSample found = query.sample(x, t);
    EXPECT_NEAR(found.distance_mm, x.norm() - radius(t), 0.003);
    EXPECT_LT(std::acos(std::min(1.0, query.normal(found, x).dot(direction))) * 180 / kPi, 0.1);
    const double velocity = 2 * 2 * kPi / 0.75 * std::cos(2 * kPi * t / 0.75);
    EXPECT_NEAR(FieldQuery::normal_velocity_mm_s(found), velocity, 0.06);  // of 16.8
    EXPECT_TRUE(found.in_band);
  }
}

TEST(FieldQuery, RefusesWhatItCannotEvaluate) {
  EXPECT_THROW(FieldQuery(nullptr, 1), Error);
  const auto field = random_payload(3, 1);
  EXPECT_THROW(FieldQuery(field, 0), Error);
  EXPECT_THROW(FieldQuery(field, std::numeric_limits<double>::quiet_NaN()), Error);
  static_assert(
      noexcept(std::declval<const FieldQuery&>().sample(std::declval<const Vec3&>(), 0.0)));
}

}  // namespace
}  // namespace beatlas::field
