/// The RV's free wall between balls, whose thickness is known at every place.
#include "pipeline/mesh/rv_wall.h"

#include <cmath>

#include <gtest/gtest.h>

#include "pipeline/mesh/mesh.h"
#include "tests/unit/mesh/beating_shapes.h"

namespace beatlas::mesh::rv_wall_tests {
namespace {

using closed_form::beating_field;

constexpr double kRvMm = 20;      // the RV is a ball around the origin
constexpr double kBaseMm = 14;    // cut flat there, as is the heart 2 mm above
const Vec3 kLvCentre(-34, 0, 0);  // and the LV a ball beside it
constexpr double kLvMm = 18;

/// Thin at -y, twice and more as thick at +y, growing with the beat.
double wall_mm(const Vec3& unit, double share) { return 4.5 + 2.5 * unit.y() + 0.5 * share; }

struct Ventricles {
  explicit Ventricles(double heart_base_mm = kBaseMm + 2) {
    const auto made = [](Structure structure, const auto& distance) {
      FieldCycle field = beating_field(distance, 2, {-60, -34, -34}, {34, 34, 34});
      field.structure = structure;
      return field;
    };
    fields.push_back(made(Structure::RvBlood, [](double, const Vec3& x) {
      return std::max(x.norm() - kRvMm, x.z() - kBaseMm);
    }));
    fields.push_back(made(Structure::LvMyocardium,
                          [](double, const Vec3& x) { return (x - kLvCentre).norm() - kLvMm; }));
    fields.push_back(made(Structure::Heart, [heart_base_mm](double share, const Vec3& x) {
      const double around_rv = x.norm() - kRvMm - wall_mm(x.normalized(), share);
      return std::max(std::min(around_rv, (x - kLvCentre).norm() - kLvMm - 1),
                      x.z() - heart_base_mm);
    }));
    StageContext context;
    rv = mesh_cycle(fields[0], {}, context);
  }
  [[nodiscard]] std::vector<double> walls(std::size_t phase, const Vec3& voxel_mm,
                                          double base_mm = kBaseMm) const {
    MapFrame frame;
    frame.rv_base_mm = {base_mm, base_mm};
    frame.voxel_mm = voxel_mm;
    return rv_wall_mm(fields, rv, phase, frame);
  }
  std::vector<FieldCycle> fields;
  SurfaceCycle rv;
};

/// Of a vertex that lies well on the free wall, below the base and off the LV.
bool on_free_wall(const Vec3& at) { return at.z() < kBaseMm - 9 && at.x() > -4; }

TEST(RvWall, IsTheWayToTheOutsideOfTheHeart) {
  const Ventricles ventricles;
  for (std::size_t p = 0; p < 2; ++p) {
    const std::vector<double> walls = ventricles.walls(p, {0.5, 0.5, 0.5});
    int seen = 0;
    double sum_mm = 0;
    for (std::size_t v = 0; v < walls.size(); ++v) {
      const Vec3 at = ventricles.rv.positions[p][v].cast<double>();
      if (!on_free_wall(at)) continue;
      ++seen;
      sum_mm += std::abs(walls[v] - wall_mm(at.normalized(), static_cast<double>(p)));
      ASSERT_NEAR(walls[v], wall_mm(at.normalized(), static_cast<double>(p)), 0.5)
          << at.transpose();
    }
    EXPECT_GT(seen, 200);
    EXPECT_LT(sum_mm / seen, 0.06);
  }
}

/// Nor where they are more than half of a normal wall, 5 mm, however thick it is.
TEST(RvWall, IsNotToldWhereTheVoxelsAreMoreThanHalfOfIt) {
  const Ventricles ventricles;
  const Vec3 voxel_mm(2, 2, 8);
  const std::vector<double> all = ventricles.walls(0, {0.1, 0.1, 0.1});
  const std::vector<double> told = ventricles.walls(0, voxel_mm);
  int kept = 0;
  int dropped = 0;
  int too_coarse = 0;
  for (std::size_t v = 0; v < all.size(); ++v) {
    const Vec3 normal = ventricles.rv.positions[0][v].cast<double>().normalized();
    const double along_mm = normal.cwiseProduct(voxel_mm).norm();
    if (all[v] == 0 || std::abs(all[v] - 2 * along_mm) < 0.5) continue;
    if (std::abs(5 - 2 * along_mm) < 0.5) continue;
    const bool is_resolved = std::min(all[v], 5.0) > 2 * along_mm;
    too_coarse += !is_resolved && all[v] > 2 * along_mm ? 1 : 0;
    // Only on the ball is this the surface's normal.
    if (!on_free_wall(ventricles.rv.positions[0][v].cast<double>())) continue;
    EXPECT_EQ(told[v], is_resolved ? all[v] : 0);
    ++(is_resolved ? kept : dropped);
  }
  EXPECT_GT(kept, 50);
  EXPECT_GT(dropped, 50);
  EXPECT_GT(too_coarse, 10);
}

TEST(RvWall, IsNeitherTheSeptumNorTheBase) {
  const Ventricles ventricles;
  const std::vector<double> walls = ventricles.walls(0, {0.1, 0.1, 0.1});
  int septal = 0;
  int basal = 0;
  for (std::size_t v = 0; v < walls.size(); ++v) {
    const Vec3 at = ventricles.rv.positions[0][v].cast<double>();
    const bool faces_lv = at.x() < -0.9 * kRvMm;
    const bool is_base = at.z() > kBaseMm - 0.1;
    if (faces_lv || is_base) {
      EXPECT_EQ(walls[v], 0) << at.transpose();
    }
    septal += faces_lv ? 1 : 0;
    basal += is_base ? 1 : 0;
  }
  EXPECT_GT(septal, 20);
  EXPECT_GT(basal, 50);
}

TEST(RvWall, IsNoneWithoutAHeartOrATricuspidPlane) {
  Ventricles ventricles;
  const auto told = [&](const MapFrame& frame) {
    const std::vector<double> walls = rv_wall_mm(ventricles.fields, ventricles.rv, 0, frame);
    return std::count_if(walls.begin(), walls.end(), [](double mm) { return mm > 0; });
  };
  MapFrame frame;
  EXPECT_EQ(told(frame), 0);
  frame.rv_base_mm = {kBaseMm, kBaseMm};
  EXPECT_GT(told(frame), 500);
  ventricles.fields.pop_back();
  EXPECT_EQ(told(frame), 0);
}

}  // namespace
}  // namespace beatlas::mesh::rv_wall_tests
