/// A package's field as a .vdb, read by OpenVDB itself.

#include "pipeline/cli/stored_distances.h"

#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>
#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>

#include "pipeline/field/field.h"
#include "pipeline/pack/pack.h"
#include "tests/package/sample_package.h"

namespace beatlas::cli {
namespace {

const Vec3 kCentre(60, 70, 80);
constexpr int kPhases = 4;

double radius_mm(int phase) { return 24 + 3 * std::cos(2 * M_PI * phase / kPhases); }

FieldCycle ball() {
  FieldCycle cycle;
  cycle.structure = Structure::Heart;
  cycle.voxel_mm = 1.5;
  cycle.inner_mm = 10;
  cycle.outer_mm = 6;
  Grid grid{{52, 52, 52}, Affine::Identity()};
  grid.mm_from_index.linear() = 1.5 * Eigen::Matrix3d::Identity();
  grid.mm_from_index.translation() = kCentre - Vec3::Constant(1.5 * 25.5);
  cycle.distance_mm.grid = grid;
  for (int p = 0; p < kPhases; ++p) {
    std::vector<float> distance;
    for (int n = 0; n < 52 * 52 * 52; ++n) {
      const double d = (grid.mm(n % 52, n / 52 % 52, n / 2704) - kCentre).norm() - radius_mm(p);
      distance.push_back(static_cast<float>(std::clamp(d, -10.0, 6.0)));
    }
    cycle.distance_mm.phases.push_back(std::move(distance));
    cycle.volume_ml.push_back(1 + p);
  }
  return cycle;
}

TEST(StoredDistances, ReachAnotherReaderAsFloatGridsInMm) {
  const FieldCycle made = ball();
  const auto stored = std::make_shared<const atlas::FieldPayload>(pack::stored_field(made, {}));
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "heart.vdb";
  field::write_vdb(file, distances_of(stored, made.volume_ml));

  openvdb::initialize();
  openvdb::io::File in(file.string());
  in.open(false);
  for (int p = 0; p < kPhases; ++p) {
    const auto grid =
        openvdb::gridPtrCast<openvdb::FloatGrid>(in.readGrid("heart_" + std::to_string(p)));
    ASSERT_TRUE(grid) << p;
    EXPECT_EQ(grid->getGridClass(), openvdb::GRID_LEVEL_SET);
    EXPECT_NEAR(grid->background(), 6, 1e-6);
    // Each value where its transform says it is, against the ball in closed form: two steps of
    // 0.02 mm, and what encode_field says of a smooth surface's samples (0.004).
    double largest = 0;
    std::size_t count = 0;
    for (auto value = grid->cbeginValueOn(); value; ++value) {
      const openvdb::Vec3d at = grid->indexToWorld(value.getCoord());
      const double d = (Vec3(at.x(), at.y(), at.z()) - kCentre).norm() - radius_mm(p);
      if (d < -8 || d > 4) continue;  // more than a voxel within the clamps
      largest = std::max(largest, std::abs(double(*value) - d));
      ++count;
    }
    EXPECT_LT(largest, 0.045) << p;
    EXPECT_GT(count, 15000U);
    // Deep inside and far outside: clamped, the sign right.
    const openvdb::tools::GridSampler<openvdb::FloatGrid, openvdb::tools::PointSampler> look(*grid);
    EXPECT_NEAR(look.wsSample({kCentre.x(), kCentre.y(), kCentre.z()}), -10, 1e-5);
    EXPECT_NEAR(look.wsSample({kCentre.x() + 200, 0, 0}), 6, 1e-5);
  }
  in.close();
}

}  // namespace
}  // namespace beatlas::cli
