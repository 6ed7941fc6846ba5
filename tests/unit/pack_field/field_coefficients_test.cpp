#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "pipeline/core/parallel.h"
#include "pipeline/pack/pack.h"
#include "pipeline/pack/payload_encoders.h"
#include "pipeline/pack/spline_prefilter.h"
#include "runtime/atlas/field_payload.h"
#include "runtime/base/error.h"
#include "runtime/field/field_query.h"
#include "tests/unit/runtime_field/test_fields.h"

namespace beatlas::pack {
namespace {

using atlas::FieldPayload;
using ::beatlas::testing::Distance;
using ::beatlas::testing::ellipsoid_distance;

constexpr double kPi = std::numbers::pi;
constexpr double kPeriod = 0.75;

struct Spec {
  Vec3 half_extent_mm = Vec3::Constant(40);
  Vec3 corner_mm = Vec3(11.3, -7.7, 23.1);  // the lattice's first sample
  double voxel_mm = 1.5;
  int phases = 15;
  double inner_mm = 15;
  double outer_mm = 6;

  [[nodiscard]] Vec3 centre() const { return corner_mm + half_extent_mm; }
};

FieldCycle clamped_field(const Spec& spec, const Distance& phi) {
  FieldCycle field;
  field.structure = Structure::Heart;
  field.voxel_mm = spec.voxel_mm;
  field.inner_mm = spec.inner_mm;
  field.outer_mm = spec.outer_mm;
  Grid& grid = field.distance_mm.grid;
  for (std::size_t a = 0; a < 3; ++a) {
    grid.size[a] =
        static_cast<int>(2 * spec.half_extent_mm[static_cast<Eigen::Index>(a)] / spec.voxel_mm) + 1;
  }
  grid.mm_from_index = Eigen::Translation3d(spec.corner_mm) * Eigen::Scaling(spec.voxel_mm);
  for (int p = 0; p < spec.phases; ++p) {
    auto& samples = field.distance_mm.phases.emplace_back();
    samples.reserve(grid.count());
    for (int k = 0; k < grid.size[2]; ++k) {
      for (int j = 0; j < grid.size[1]; ++j) {
        for (int i = 0; i < grid.size[0]; ++i) {
          const double value = phi(grid.mm(i, j, k), kPeriod * p / spec.phases);
          samples.push_back(static_cast<float>(std::clamp(value, -spec.inner_mm, spec.outer_mm)));
        }
      }
    }
  }
  field.volume_ml.assign(static_cast<std::size_t>(spec.phases), 1);
  return field;
}

struct Errors {
  double distance_mm = 0;
  double normal_deg = 0;
  int samples = 0;
  int out_of_band = 0;
};

// Largest errors at random points whose true distance is at least `margin` voxels in the band.
Errors measure(const Spec& spec, const FieldPayload& payload, const Distance& phi, double margin,
               double widest_mm) {
  const field::FieldQuery query(std::make_shared<FieldPayload>(payload), kPeriod);
  std::mt19937 random(17);
  std::uniform_real_distribution<double> u(-1, 1);
  Errors errors;
  while (errors.samples < 20000) {
    const Vec3 x = spec.centre() + widest_mm * Vec3(u(random), u(random), u(random));
    const double t = 2 * u(random);
    const double expected = phi(x, t);
    if (expected < -spec.inner_mm + margin * spec.voxel_mm ||
        expected > spec.outer_mm - margin * spec.voxel_mm) {
      continue;
    }
    const field::FieldSample found = query.sample(x, t);
    constexpr double h = 1e-4;
    Vec3 normal;
    for (int a = 0; a < 3; ++a) {
      normal[a] = phi(x + h * Vec3::Unit(a), t) - phi(x - h * Vec3::Unit(a), t);
    }
    ++errors.samples;
    errors.out_of_band += found.in_band ? 0 : 1;
    errors.distance_mm = std::max(errors.distance_mm, std::abs(found.distance_mm - expected));
    const double cosine = std::min(1.0, query.normal(found, x).dot(normal.normalized()));
    errors.normal_deg = std::max(errors.normal_deg, std::acos(cosine) * 180 / kPi);
  }
  ::testing::Test::RecordProperty("distance_um", static_cast<int>(1000 * errors.distance_mm));
  ::testing::Test::RecordProperty("normal_mdeg", static_cast<int>(1000 * errors.normal_deg));
  return errors;
}

Distance sphere(const Spec& spec, double radius, double amplitude) {
  return [=](const Vec3& x, double t) {
    return (x - spec.centre()).norm() - radius - amplitude * std::sin(2 * kPi * t / kPeriod);
  };
}

// The contract: within two voxels of the clamps the distance is right to 0.02 mm.
constexpr double kContractMm = 0.02;

TEST(EncodeField, StaticSphereIsRightInTheBand) {
  const Spec spec{.phases = 1};
  const auto phi = sphere(spec, 28, 0);
  const Errors errors = measure(spec, encode_field(clamped_field(spec, phi), {}), phi, 2, 36);
  EXPECT_LT(errors.distance_mm, kContractMm);
  EXPECT_LT(errors.normal_deg, 0.2);
  EXPECT_EQ(errors.out_of_band, 0);
}

TEST(EncodeField, BeatingSphereIsRightInTheBand) {
  // Fastest physiological wall: 5 mm amplitude, so the clamps sweep over many samples.
  const Spec spec;
  const auto phi = sphere(spec, 28, 5);
  const FieldPayload payload = encode_field(clamped_field(spec, phi), {});
  const Errors errors = measure(spec, payload, phi, 2, 39);
  EXPECT_LT(errors.distance_mm, kContractMm);
  EXPECT_LT(errors.normal_deg, 0.3);
  EXPECT_EQ(errors.out_of_band, 0);
  // Up to where in_band ends it stays within a hundredth of a voxel or so.
  const Errors edge = measure(spec, payload, phi, 1.02, 39);
  EXPECT_LT(edge.distance_mm, 2 * kContractMm);
  EXPECT_EQ(edge.out_of_band, 0);
}

TEST(EncodeField, BeatingEllipsoidIsRightInTheBand) {
  // Kept to 10 mm: deeper it nears the ellipsoid's own medial axis, where no spline follows.
  const Spec spec{.half_extent_mm = Vec3(36, 32, 40), .inner_mm = 10};
  const Distance phi = [&](const Vec3& x, double t) {
    const double s = std::sin(2 * kPi * t / kPeriod);
    return ellipsoid_distance(Vec3(26 + 1.5 * s, 22 + 2 * s, 30 - s), x - spec.centre());
  };
  const Errors errors = measure(spec, encode_field(clamped_field(spec, phi), {}), phi, 2, 39);
  EXPECT_LT(errors.distance_mm, kContractMm);
  EXPECT_LT(errors.normal_deg, 0.5);
  EXPECT_EQ(errors.out_of_band, 0);
}

TEST(PackedField, PositionIsRightToFiveMicrometresOverTheCycle) {
  // Hard case 7: 15 frames of +-5 mm in 0.75 s, as a package gives them back.
  const Spec spec;
  const auto phi = sphere(spec, 28, 5);
  const FieldPayload payload = atlas::decode_field(
      pack_field(encode_field(clamped_field(spec, phi), {}), EncodeOptions{}.step_mm),
      Structure::Heart);
  const field::FieldQuery query(std::make_shared<FieldPayload>(payload), kPeriod);
  std::mt19937 random(29);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> u(0, 1);
  double largest_mm = 0;
  double squares = 0;
  constexpr int kCount = 50000;
  for (int n = 0; n < kCount; ++n) {
    const Vec3 direction = Vec3(normal(random), normal(random), normal(random)).normalized();
    const double t = kPeriod * u(random);
    const double radius = 28 + 5 * std::sin(2 * kPi * t / kPeriod);
    const field::FieldSample found = query.sample(spec.centre() + radius * direction, t);
    const double error_mm = found.distance_mm / found.gradient.norm();
    largest_mm = std::max(largest_mm, std::abs(error_mm));
    squares += error_mm * error_mm;
  }
  RecordProperty("largest_um", static_cast<int>(1000 * largest_mm));
  RecordProperty("rms_nm", static_cast<int>(1e6 * std::sqrt(squares / kCount)));
  EXPECT_LE(largest_mm, 0.005);
}

TEST(EncodeField, AThinWallIsRightOnBothSides) {
  // A shell 9 mm thick, as a ventricle's wall: halfway its distance has a ridge that no spline
  // follows. It rings in space and, as it sweeps, in time; on the wall's two faces, three voxels
  // off, that stays below the contract for a wall that moves 1.3 mm a phase.
  const Spec spec{.half_extent_mm = Vec3::Constant(42)};
  const Distance phi = [&](const Vec3& x, double t) {
    const double middle = 27 + 3 * std::sin(2 * kPi * t / kPeriod);
    return std::abs((x - spec.centre()).norm() - middle) - 4.5;
  };
  const FieldPayload payload = encode_field(clamped_field(spec, phi), {});
  const field::FieldQuery query(std::make_shared<FieldPayload>(payload), kPeriod);
  std::mt19937 random(23);
  std::uniform_real_distribution<double> u(-38, 38);
  int compared = 0;
  double largest = 0;
  while (compared < 20000) {
    const Vec3 x = spec.centre() + Vec3(u(random), u(random), u(random));
    const double t = u(random);
    const double expected = phi(x, t);
    const double found = query.sample(x, t).distance_mm;
    if (std::abs(expected) > 0.3) {
      ASSERT_EQ(found < 0, expected < 0) << expected;
    }
    if (expected < 0 || expected > 3) continue;
    ++compared;
    largest = std::max(largest, std::abs(found - expected));
  }
  RecordProperty("distance_um", static_cast<int>(1000 * largest));
  EXPECT_LT(largest, kContractMm);
}

TEST(EncodeField, OutsideTheBandTheSignIsRightAndTheMagnitudeClamped) {
  const Spec spec;
  const auto phi = sphere(spec, 27, 5);
  const FieldPayload payload = encode_field(clamped_field(spec, phi), {});
  const field::FieldQuery query(std::make_shared<FieldPayload>(payload), kPeriod);
  std::mt19937 random(2);
  std::uniform_real_distribution<double> u(-60, 60);
  for (int n = 0; n < 50000; ++n) {
    const Vec3 x = spec.centre() + Vec3(u(random), u(random), u(random));
    const double t = u(random);
    const double expected = phi(x, t);
    constexpr double kRounding = 1e-4;  // float sums near the clamp
    const double found = query.sample(x, t).distance_mm;
    if (expected > spec.outer_mm + 0.02) {
      ASSERT_NEAR(found, spec.outer_mm, kRounding) << expected;
    } else if (expected < -spec.inner_mm - 0.02) {
      ASSERT_NEAR(found, -spec.inner_mm, kRounding) << expected;
    } else {
      ASSERT_NEAR(found, expected, 0.5 * spec.voxel_mm);
    }
  }
}

TEST(EncodeField, ThePayloadIsWellFormedAndSparse) {
  const Spec spec{.phases = 5};
  const auto phi = sphere(spec, 28, 3);
  const FieldPayload payload = encode_field(clamped_field(spec, phi), {});
  ASSERT_EQ(payload.blocks.size(),
            static_cast<std::size_t>(payload.block_count[0] * payload.block_count[1] *
                                     payload.block_count[2]));
  std::int32_t next_leaf = 0;
  for (std::int32_t entry : payload.blocks) {
    if (entry < 0) continue;
    EXPECT_EQ(entry, next_leaf++);
  }
  ASSERT_EQ(static_cast<std::size_t>(next_leaf), payload.leaf_count());
  EXPECT_EQ(payload.coefficients.size(), payload.leaf_count() * 512 * 5);
  EXPECT_EQ(payload.phases, 5);
  EXPECT_DOUBLE_EQ(payload.step_mm, 0.02 / 8);
  // Blocks of the shell that the band sweeps, (radius + 3 + 6)^3 - (radius - 3 - 15)^3, two samples
  // more in the maximum norm on either side, and as a block may only touch it, half its diagonal.
  const double more = 3 * std::sqrt(3.0) + 4 * 1.5 * std::sqrt(3.0);
  const double r_out = 37 + more, r_in = std::max(0.0, 10 - more);
  const double most = 4 * kPi / 3 * (std::pow(r_out, 3) - std::pow(r_in, 3)) / std::pow(8 * 1.5, 3);
  EXPECT_LT(static_cast<double>(payload.leaf_count()), most);
}

TEST(EncodeField, TheStepGrowsWhereACoefficientWouldNotFit) {
  const Spec spec{.voxel_mm = 2, .phases = 1, .inner_mm = 20, .outer_mm = 6};
  const auto phi = sphere(spec, 28, 0);
  EncodeOptions options;
  options.step_mm = 0.0005;  // counts of an eighth reach 2 mm
  const FieldPayload payload = encode_field(clamped_field(spec, phi), options);
  EXPECT_GT(payload.step_mm, 20.0 / 32767);
  EXPECT_LT(payload.step_mm, 40.0 / 32767);
  EXPECT_LT(measure(spec, payload, phi, 2, 36).distance_mm, kContractMm);
}

TEST(EncodeField, ASampleThatChangesSideUnseenIsStored) {
  // One phase far outside, the next far inside: no sample of a fast wall is ever in a thin band.
  Spec spec{.half_extent_mm = Vec3::Constant(60),
            .voxel_mm = 3,
            .phases = 4,
            .inner_mm = 3,
            .outer_mm = 3};
  const Distance phi = [&](const Vec3& x, double t) {
    return (x - spec.centre()).norm() - (t < 0.3 ? 45 : 20);
  };
  const FieldPayload payload = encode_field(clamped_field(spec, phi), {});
  const field::FieldQuery query(std::make_shared<FieldPayload>(payload), kPeriod);
  const Vec3 x = spec.centre() + Vec3(32, 0, 0);
  EXPECT_EQ(query.sample(x, 0.5 / 4 * kPeriod).distance_mm, -3);
  EXPECT_EQ(query.sample(x, 2.5 / 4 * kPeriod).distance_mm, 3);
}

TEST(EncodeField, GivesTheSameBytesForAnyNumberOfThreads) {
  const Spec spec{.voxel_mm = 2, .phases = 4};
  const FieldCycle field = clamped_field(spec, sphere(spec, 25, 4));
  set_thread_count(1);
  const FieldPayload one = encode_field(field, {});
  set_thread_count(3);
  const FieldPayload three = encode_field(field, {});
  set_thread_count(0);
  EXPECT_EQ(one.coefficients, three.coefficients);
  EXPECT_EQ(one.blocks, three.blocks);
  EXPECT_EQ(one.step_mm, three.step_mm);
}

TEST(EncodeField, RefusesABadField) {
  const Spec spec{.voxel_mm = 3, .phases = 2};
  const FieldCycle good = clamped_field(spec, sphere(spec, 25, 2));
  EXPECT_NO_THROW((void)encode_field(good, {}));
  const auto expect_refused = [](const FieldCycle& field, const std::string& words) {
    try {
      (void)encode_field(field, {});
      ADD_FAILURE() << "accepted; expected: " << words;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
  };
  FieldCycle bad = good;
  bad.distance_mm.phases[1][5] = std::numeric_limits<float>::quiet_NaN();
  expect_refused(bad, "no number");
  bad = good;
  bad.distance_mm.phases[1].pop_back();
  expect_refused(bad, "number of samples");
  bad = good;
  bad.distance_mm.phases.clear();
  expect_refused(bad, "empty");
  bad = good;
  bad.distance_mm.grid.mm_from_index.linear()(2, 2) = 4;
  expect_refused(bad, "isotropic");
  bad = good;
  bad.outer_mm = 1;
  expect_refused(bad, "less than a voxel");
  bad = good;
  for (auto& phase : bad.distance_mm.phases) phase.assign(phase.size(), 6.0F);
  expect_refused(bad, "no surface");
  bad = good;
  bad.distance_mm.phases[1][0] = -1;
  expect_refused(bad, "edge");
  EncodeOptions options;
  options.step_mm = 1;
  EXPECT_THROW((void)encode_field(good, options), Error);
}

TEST(Prefilter, InvertsTheBSplineAtTheSamples) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> u(-1, 1);
  for (std::size_t n : {1U, 2U, 3U, 4U, 7U, 15U, 64U}) {
    std::vector<double> samples(2 * n);
    for (double& s : samples) s = u(random);
    std::vector<double> periodic = samples;
    prefilter_periodic(periodic.data(), n, 2);
    std::vector<double> mirrored = samples;
    prefilter_mirrored(mirrored.data(), n, 2);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t l = 0; l < 2; ++l) {
        const std::size_t before = (i + n - 1) % n, after = (i + 1) % n;
        EXPECT_NEAR(
            (periodic[before * 2 + l] + 4 * periodic[i * 2 + l] + periodic[after * 2 + l]) / 6,
            samples[i * 2 + l], 1e-13);
        if (n == 1) continue;
        const std::size_t left = i == 0 ? 1 : i - 1, right = i + 1 == n ? n - 2 : i + 1;
        EXPECT_NEAR(
            (mirrored[left * 2 + l] + 4 * mirrored[i * 2 + l] + mirrored[right * 2 + l]) / 6,
            samples[i * 2 + l], 1e-13);
      }
    }
  }
}

}  // namespace
}  // namespace beatlas::pack
