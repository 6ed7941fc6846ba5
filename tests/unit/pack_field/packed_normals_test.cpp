/// The normal's error in a package made from voxels, and what storing adds to it.
#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <numbers>

#include <gtest/gtest.h>

#include "pipeline/edges/mask_surface.h"
#include "pipeline/field/field.h"
#include "pipeline/pack/pack.h"
#include "pipeline/pack/payload_encoders.h"
#include "pipeline/shape/workspace.h"
#include "runtime/atlas/field_payload.h"
#include "runtime/field/field_query.h"
#include "tests/unit/shape/made_shapes.h"

namespace beatlas::pack {
namespace {

const Vec3 kMiddle(12, -30, 45);
/// [mm] of a ball's middle from a voxel's, along the axes of voxels; across slices evenly spread.
const std::array<Vec3, 6> kOffs{Vec3(0, 0, 0),       Vec3(0.3, 0.2, 0.3), Vec3(0.1, 0.4, 0.6),
                                Vec3(0.4, 0.3, 0.9), Vec3(0.2, 0.5, 1.2), Vec3(0.5, 0.1, 1.5)};

/// 95th percentiles [deg] at points of a ball's surface evenly spread.
struct Errors {
  double before = 0;  ///< of the coefficients as encoded, against the ball
  double after = 0;   ///< as a package gives them back, against the ball
  double added = 0;   ///< between the two
  std::vector<double> all_after;
};

double angle_deg(const Vec3& a, const Vec3& b) {
  return std::asin(std::min(1.0, a.cross(b).norm())) * 180 / std::numbers::pi;
}

double p95(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() * 95 / 100];
}

/// From coverage of 1 x 1 x 3 mm voxels, through shape and field, without what segmentation
/// smooths. @param off_mm of the ball's middle from a voxel's, along the axes of voxels
Errors normal_errors(double radius_mm, bool binary, const Vec3& off_mm = Vec3::Zero()) {
  const auto size = static_cast<int>(2 * radius_mm + 26);
  const Grid grid = shape::made::oblique_grid({size, size, size / 3 + 2}, {1, 1, 3}, kMiddle);
  const Vec3 middle =
      kMiddle + grid.mm_from_index.linear() * off_mm.cwiseQuotient(grid.spacing_mm());
  Segmentation segmentation = shape::made::segmentation_of(grid, 1);
  std::vector<float> coverage = shape::made::ball_coverage(grid, middle, radius_mm);
  if (binary) {
    std::vector<std::uint8_t> mask(coverage.size());
    std::transform(coverage.begin(), coverage.end(), mask.begin(),
                   [](float share) { return static_cast<std::uint8_t>(share >= 0.5F); });
    coverage = edges::smooth_coverage(grid, mask);
  }
  segmentation.coverage.phases[Structure::Heart] = {std::move(coverage)};
  StageContext quiet;
  const Affine map = shape::workspace_from_lps(grid, segmentation.coverage);
  const auto shapes = shape::shapes_in_workspace(segmentation, map, {}, quiet);
  const EncodeOptions options;
  const auto encoded = std::make_shared<atlas::FieldPayload>(
      encode_field(field::build_field(shapes.front(), {}, quiet), options));
  const auto packed = std::make_shared<atlas::FieldPayload>(
      atlas::decode_field(pack_field(*encoded, options.step_mm), Structure::Heart));
  const field::FieldQuery before(encoded, 1);
  const field::FieldQuery after(packed, 1);
  std::vector<double> of_before;
  std::vector<double> of_after;
  std::vector<double> added;
  constexpr int kRays = 5000;
  for (int n = 0; n < kRays; ++n) {
    const double z = 1 - (2 * n + 1.0) / kRays;
    const double angle = n * std::numbers::pi * (3 - std::sqrt(5.0));
    const double r = std::sqrt(1 - z * z);
    const Vec3 direction(r * std::cos(angle), r * std::sin(angle), z);
    const Vec3 x = map * middle + radius_mm * direction;
    const Vec3 normal_before = before.normal(before.sample(x, 0), x);
    const Vec3 normal_after = after.normal(after.sample(x, 0), x);
    of_before.push_back(angle_deg(normal_before, direction));
    of_after.push_back(angle_deg(normal_after, direction));
    added.push_back(angle_deg(normal_before, normal_after));
  }
  Errors out{p95(of_before), p95(of_after), p95(added), of_after};
  ::testing::Test::RecordProperty("before_mdeg", static_cast<int>(1000 * out.before));
  ::testing::Test::RecordProperty("after_mdeg", static_cast<int>(1000 * out.after));
  ::testing::Test::RecordProperty("added_mdeg", static_cast<int>(1000 * out.added));
  return out;
}

TEST(PackedNormals, AreStoredToADegreeWhereTheFieldIsRough) {
  // The whole error that hard case 9 allows a normal; a smooth field stays far below it. It is
  // independent of the field's own, so it adds little to it.
  for (const bool binary : {false, true}) {
    const Errors errors = normal_errors(30, binary);
    EXPECT_LE(errors.added, 1);
    EXPECT_GT(errors.added, 0.001);  // it is quantised, so this can fail
    EXPECT_LE(errors.after, std::hypot(errors.before, errors.added) + 0.1);
  }
}

// Of a package from partial volumes in voxels of 1 x 1 x 3 mm, without noise.
TEST(PackedNormals, HardCase9AreWithinADegreeFromPartialVolumes) {
  for (const double radius_mm : {20.0, 30.0, 40.0}) {
    for (const Vec3& off : kOffs) {
      const std::vector<double> errors = normal_errors(radius_mm, false, off).all_after;
      const double worst = *std::max_element(errors.begin(), errors.end());
      std::cout << radius_mm << " mm: " << worst << " deg, p95 " << p95(errors) << "\n";
      EXPECT_LE(worst, 1.0) << radius_mm << " mm, off by " << off.transpose();
    }
  }
}

// The same of a mask, a staircase, over where the ball lies in the slices: a pole that just misses
// one is known least.
TEST(PackedNormals, HardCase10AreWithinTwoDegreesAt95PercentFromAMask) {
  for (const double radius_mm : {20.0, 30.0, 40.0}) {
    std::vector<double> all;
    for (const Vec3& off : kOffs) {
      const Errors errors = normal_errors(radius_mm, true, off);
      std::cout << radius_mm << " mm, off by " << off.transpose() << ": p95 " << errors.after
                << " deg\n";
      all.insert(all.end(), errors.all_after.begin(), errors.all_after.end());
    }
    std::cout << radius_mm << " mm: p95 " << p95(all) << " deg\n";
    EXPECT_LE(p95(all), 2.0) << radius_mm << " mm";
  }
}

}  // namespace
}  // namespace beatlas::pack
