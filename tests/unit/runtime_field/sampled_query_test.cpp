#include "runtime/field/sampled_query.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "tests/unit/runtime_field/test_fields.h"

namespace beatlas::field::sampled_query_tests {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRr = 0.75;
constexpr double kStep = 0.002;

using Phi = ::beatlas::testing::Distance;

std::shared_ptr<const FieldQuery> field_of(const Phi& phi, double voxel_mm, int phases) {
  const int blocks = static_cast<int>(std::ceil(60 / voxel_mm / 8));
  return std::make_shared<const FieldQuery>(
      ::beatlas::testing::dense_payload({.origin_mm = Vec3::Constant(-30),
                                         .voxel_mm = voxel_mm,
                                         .blocks = {blocks, blocks, blocks},
                                         .phases = phases,
                                         .rr_interval_s = kRr,
                                         .step_mm = kStep},
                                        phi),
      kRr);
}

double beating_sphere(const Vec3& x, double t) {
  return x.norm() - 18 - 4 * std::sin(2 * kPi * t / kRr);
}

/// Largest and mean error of the distance over points near the sphere, at times off the frames.
struct Errors {
  double largest = 0;
  double mean = 0;
};
Errors errors(const SampledQuery& query, const Phi& phi) {
  std::mt19937 random(3);
  std::normal_distribution<double> direction;
  std::uniform_real_distribution<double> u(0, 1);
  Errors out;
  constexpr int kPoints = 4000;
  for (int n = 0; n < kPoints; ++n) {
    const Vec3 d = Vec3(direction(random), direction(random), direction(random)).normalized();
    const Vec3 x = (16 + 4 * u(random)) * d;
    const double t = kRr * u(random);
    const double error = std::abs(query.sample(x, t).distance_mm - phi(x, t));
    out.largest = std::max(out.largest, error);
    out.mean += error / kPoints;
  }
  return out;
}

TEST(SampledQuery, EveryModeGivesTheSamplesAtTheLatticeAndFrames) {
  const auto field = field_of(beating_sphere, 1.5, 15);
  for (const SpatialMode space : kSpatialModes) {
    for (const TemporalMode time : kTemporalModes) {
      const SampledQuery query(field, space, time);
      for (int n = 0; n < 40; ++n) {
        const Vec3 x = Vec3::Constant(-30) + 1.5 * Vec3(10 + n % 17, 8 + n % 13, 9 + n % 11);
        const double t = kRr * (n % 15) / 15.0;
        // A step in the spline and one in the samples.
        EXPECT_NEAR(query.sample(x, t).distance_mm, beating_sphere(x, t), 2 * kStep)
            << mode_name(space) << " " << mode_name(time);
      }
    }
  }
}

TEST(SampledQuery, IsExactForWhatEachModeCanRepresent) {
  const auto plane = [](const Vec3& x, double) { return Vec3(0.6, -0.48, 0.64).dot(x) + 3; };
  const auto still = field_of(plane, 1.5, 5);
  const SampledQuery trilinear(still, SpatialMode::Trilinear, TemporalMode::Linear);
  const Vec3 x(3.31, -2.17, 1.93);
  const FieldSample sample = trilinear.sample(x, 0.21);
  EXPECT_NEAR(sample.distance_mm, plane(x, 0), 2 * kStep);
  EXPECT_LT((sample.gradient - Vec3(0.6, -0.48, 0.64)).norm(), 2 * kStep);
  EXPECT_NEAR(sample.rate_mm_s, 0, 1e-6);
  EXPECT_TRUE(sample.in_band);
  // Nearest: the value of the rounded place, the direction of its neighbours.
  const SampledQuery nearest(still, SpatialMode::NearestVoxel, TemporalMode::NearestFrame);
  const Vec3 rounded = (x / 1.5).array().round() * 1.5;
  EXPECT_NEAR(nearest.sample(x, 0.21).distance_mm, plane(rounded, 0), 2 * kStep);
  EXPECT_LT((nearest.sample(x, 0.21).gradient - Vec3(0.6, -0.48, 0.64)).norm(), 2 * kStep);
}

TEST(SampledQuery, InTimeTakesTheNearestFrameALineOrTheSpline) {
  const auto rising = [](const Vec3& x, double t) {
    return x.x() + 5 * std::sin(2 * kPi * t / kRr);
  };
  const auto field = field_of(rising, 3, 10);
  const Vec3 x(0, 0, 0);
  const double frame_s = kRr / 10;
  const double t = 0.3 * frame_s;
  const auto at = [&](TemporalMode mode, double when) {
    return SampledQuery(field, SpatialMode::Trilinear, mode).sample(x, when).distance_mm;
  };
  const double first = rising(x, 0);
  const double second = rising(x, frame_s);
  EXPECT_NEAR(at(TemporalMode::NearestFrame, t), first, 2 * kStep);
  EXPECT_NEAR(at(TemporalMode::NearestFrame, 0.7 * frame_s), second, 2 * kStep);
  EXPECT_NEAR(at(TemporalMode::Linear, t), 0.7 * first + 0.3 * second, 2 * kStep);
  // The periodic cubic spline through ten samples of a sine errs by 1.4e-3 of its amplitude.
  EXPECT_NEAR(at(TemporalMode::PeriodicCubic, t), rising(x, t), 5 * 1.4e-3 + 2 * kStep);
  for (const TemporalMode mode : kTemporalModes) {
    EXPECT_NEAR(at(mode, t + 7 * kRr), at(mode, t), 1e-6);
    EXPECT_NEAR(at(mode, t - 7 * kRr), at(mode, t), 1e-6);
    EXPECT_NEAR(at(mode, 9.6 * frame_s), at(mode, -0.4 * frame_s), 1e-6);  // where the cycle wraps
  }
}

TEST(SampledQuery, CubicIsTheSplineItself) {
  const auto field = field_of(beating_sphere, 1.5, 15);
  const SampledQuery query(field, SpatialMode::Cubic, TemporalMode::PeriodicCubic);
  for (int n = 0; n < 200; ++n) {
    const Vec3 x(0.1 * n, 12 - 0.07 * n, 0.03 * n);
    const FieldSample a = query.sample(x, 0.01 * n);
    const FieldSample b = field->sample(x, 0.01 * n);
    EXPECT_EQ(a.distance_mm, b.distance_mm);
    EXPECT_EQ(a.gradient, b.gradient);
    EXPECT_EQ(a.rate_mm_s, b.rate_mm_s);
  }
}

TEST(SampledQuery, ErrorsFallFromNearestOverLinearToCubicInSpaceAndInTime) {
  const auto still = [](const Vec3& x, double) { return x.norm() - 18; };
  const auto field = field_of(still, 3, 4);
  const auto in_space = [&](SpatialMode mode) {
    return errors(SampledQuery(field, mode, TemporalMode::PeriodicCubic), still);
  };
  const Errors nearest = in_space(SpatialMode::NearestVoxel);
  const Errors trilinear = in_space(SpatialMode::Trilinear);
  const Errors cubic = in_space(SpatialMode::Cubic);
  // |phi| changes by no more than the way to the nearest lattice point: half a voxel's diagonal.
  EXPECT_LE(nearest.largest, 1.5 * std::sqrt(3.0) + 2 * kStep);
  EXPECT_GT(nearest.mean, 0.4);  // a quarter of the voxel, less in oblique directions
  // h^2 / 8 times the sum of both curvatures, 2 / r, at r = 16.
  EXPECT_LE(trilinear.largest, 9.0 / 8 * 2 / 14);
  EXPECT_LT(trilinear.mean, 0.2 * nearest.mean);
  EXPECT_LT(cubic.mean, 0.1 * trilinear.mean);

  const auto moving = field_of(beating_sphere, 1.5, 12);
  const auto in_time = [&](TemporalMode mode) {
    return errors(SampledQuery(moving, SpatialMode::Cubic, mode), beating_sphere);
  };
  const Errors frame = in_time(TemporalMode::NearestFrame);
  const Errors line = in_time(TemporalMode::Linear);
  const Errors spline = in_time(TemporalMode::PeriodicCubic);
  EXPECT_LE(frame.largest, 4 * 2 * kPi / 12 / 2 + 0.05);              // speed times half a frame
  EXPECT_LE(line.largest, 4 * std::pow(2 * kPi / 12, 2) / 8 + 0.05);  // (2 pi / N)^2 / 8
  EXPECT_LT(line.mean, 0.3 * frame.mean);
  EXPECT_LT(spline.mean, 0.1 * line.mean);
}

TEST(SampledQuery, DerivativesAreThoseOfItsOwnFunction) {
  const auto field = field_of(beating_sphere, 2, 12);
  const Vec3 x(9.3, -11.2, 8.1);  // within a cell, and the steps below stay there
  const double t = 0.40;
  for (const SpatialMode space : {SpatialMode::Trilinear, SpatialMode::Cubic}) {
    for (const TemporalMode time : {TemporalMode::Linear, TemporalMode::PeriodicCubic}) {
      const SampledQuery query(field, space, time);
      const FieldSample sample = query.sample(x, t);
      constexpr double kH = 1e-2;
      constexpr double kDt = 1e-3;
      for (int axis = 0; axis < 3; ++axis) {
        const Vec3 h = kH * Vec3::Unit(axis);
        const double slope =
            (query.sample(x + h, t).distance_mm - query.sample(x - h, t).distance_mm) / (2 * kH);
        EXPECT_NEAR(sample.gradient[axis], slope, 1e-3);
      }
      const double rate =
          (query.sample(x, t + kDt).distance_mm - query.sample(x, t - kDt).distance_mm) / (2 * kDt);
      EXPECT_NEAR(sample.rate_mm_s, rate, 0.02);
    }
  }
}

TEST(SampledQuery, FarAwayAndWithoutANumberIsOutside) {
  const auto field = field_of(beating_sphere, 3, 4);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const SpatialMode space : kSpatialModes) {
    for (const TemporalMode time : kTemporalModes) {
      const SampledQuery query(field, space, time);
      EXPECT_EQ(query.sample(Vec3(500, 0, 0), 0).distance_mm, 60);
      EXPECT_EQ(query.sample(Vec3(kNan, 0, 0), 0).distance_mm, 60);
      EXPECT_EQ(query.sample(Vec3(0, 0, 0), kNan).distance_mm, 60);
      EXPECT_EQ(query.sample(Vec3(0, 0, 0), kInfinity).distance_mm, 60);
      EXPECT_FALSE(query.sample(Vec3(500, 0, 0), 0).in_band);
    }
  }
}

TEST(SampledQuery, RefusesNoField) {
  EXPECT_THROW(SampledQuery(nullptr, SpatialMode::Trilinear, TemporalMode::Linear), Error);
}

}  // namespace
}  // namespace beatlas::field::sampled_query_tests
