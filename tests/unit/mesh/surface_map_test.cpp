#include "pipeline/mesh/surface_map.h"

#include <cmath>
#include <numbers>
#include <set>

#include <gtest/gtest.h>

#include "pipeline/mesh/mesh.h"
#include "tests/unit/mesh/beating_shapes.h"

namespace beatlas::mesh {
namespace {

using closed_form::beating_field;

constexpr double kInnerMm = 16;
constexpr double kOuterMm = 25;
constexpr double kBaseMm = 12;

double inner_mm(double share) { return kInnerMm - 4 * share; }

// A ball of blood in a shell of muscle, both cut flat at the base.
struct Ventricle {
  Ventricle() {
    StageContext context;
    fields.push_back(beating_field(
        [](double share, const Vec3& x) {
          return std::max(x.norm() - inner_mm(share), x.z() - kBaseMm);
        },
        2, {-22, -22, -22}, {22, 22, 22}));
    fields.back().structure = Structure::LvBlood;
    fields.push_back(beating_field(
        [](double share, const Vec3& x) {
          return std::max({x.norm() - kOuterMm, inner_mm(share) - x.norm(), x.z() - kBaseMm});
        },
        2, {-32, -32, -32}, {32, 32, 24}));
    fields.back().structure = Structure::LvMyocardium;
    for (const FieldCycle& field : fields) surfaces.push_back(mesh_cycle(field, {}, context));
  }
  std::vector<FieldCycle> fields;
  std::vector<SurfaceCycle> surfaces;
};

// Heart frame: z to the base, x to the RV, y to the front; in the patient and in the workspace
// turned each its own way, so that a frame taken for another shows.
struct Turned {
  Affine lps_from_heart = Affine::Identity();
  Affine workspace_from_lps = Affine::Identity();
  LongAxis axis;
  Turned() {
    Eigen::Matrix3d axes;
    axes.col(2) = -Vec3(0.60, -0.55, -0.58).normalized();
    axes.col(0) = Vec3(-0.80, -0.50, -0.30);
    axes.col(0) = (axes.col(0) - axes.col(0).dot(axes.col(2)) * axes.col(2)).normalized();
    axes.col(1) = axes.col(2).cross(axes.col(0));
    lps_from_heart.linear() = axes;
    lps_from_heart.translation() = Vec3(14, -3, 8);
    // The shapes' own frame is the workspace.
    workspace_from_lps = lps_from_heart.inverse();
    axis.origin_mm = lps_from_heart * Vec3(0, 0, 0);
    axis.towards_base = axes.col(2);
    axis.apex_mm = {-kOuterMm, -kOuterMm};
    axis.lv_base_mm = {kBaseMm, kBaseMm};
  }
};

/// Of both faces of the LV's wall.
std::vector<SurfaceMap> lv_maps(const Ventricle& ventricle, const MapFrame& frame) {
  std::vector<SurfaceMap> out;
  for (const Structure structure : {Structure::LvBlood, Structure::LvMyocardium}) {
    auto map = surface_map(structure, ventricle.fields, ventricle.surfaces, frame);
    if (map) out.push_back(std::move(*map));
  }
  return out;
}

MapFrame frame_of(const Turned& turned, const Vec3& rv_centre_mm) {
  LongAxis axis = turned.axis;
  axis.rv_centre_mm = turned.lps_from_heart * rv_centre_mm;
  return map_frame(axis, turned.workspace_from_lps, {1, 1, 1}).value();
}

TEST(SurfaceMaps, ThicknessIsThatOfTheShell) {
  const Ventricle ventricle;
  const std::vector<SurfaceMap> maps = lv_maps(ventricle, frame_of(Turned(), {40, 2, 5}));
  ASSERT_EQ(maps.size(), 2U);
  for (std::size_t m = 0; m < 2; ++m) {
    for (std::size_t p = 0; p < 2; ++p) {
      const double want = kOuterMm - inner_mm(static_cast<double>(p));
      double error_mm = 0;
      int count = 0;
      int none = 0;
      for (std::size_t v = 0; v < maps[m].thickness_mm[p].size(); ++v) {
        const Vec3f& x = ventricle.surfaces[m].positions[p][v];
        const double thick = maps[m].thickness_mm[p][v];
        if (x.z() > kBaseMm - 0.1) {  // the flat base is no wall
          none += std::abs(x.head<2>().norm() - 9.0) < 3 && m == 0 && thick > 0 ? 1 : 0;
          continue;
        }
        if (x.z() > kBaseMm - 6) continue;
        error_mm += std::abs(thick - want);
        ++count;
      }
      EXPECT_GT(count, 500);
      EXPECT_LT(error_mm / count, 0.06) << "map " << m << " phase " << p;
      EXPECT_LE(none, 2);
    }
  }
}

TEST(SurfaceMaps, NamesFollowTheAxisAndTheRightVentricle) {
  const Ventricle ventricle;
  const Turned turned;
  const MapFrame frame = frame_of(turned, {40, 0, 5});
  EXPECT_NEAR((frame.septal - Vec3::UnitX()).norm(), 0, 1e-12);
  EXPECT_NEAR((frame.anterior - Vec3::UnitY()).norm(), 0, 1e-12);
  const std::vector<SurfaceMap> maps = lv_maps(ventricle, frame);
  ASSERT_EQ(maps.size(), 2U);
  std::set<int> seen;
  for (const SurfaceMap& map : maps) {
    const std::vector<Vec3f>& at =
        ventricle.surfaces[map.structure == Structure::LvBlood ? 0 : 1].positions[0];
    for (std::size_t v = 0; v < at.size(); ++v) {
      const double share = (at[v].z() + kOuterMm) / (kBaseMm + kOuterMm);
      ASSERT_NEAR(map.long_axis[v], std::clamp(share, 0.0, 1.0), 6e-5);
      seen.insert(map.segment[v]);
      if (at[v].head<2>().norm() < 3) continue;
      // From the front (y) towards the RV (x), in degrees.
      double turn = std::atan2(at[v].x(), at[v].y()) * 180 / std::numbers::pi;
      if (turn < 0) turn += 360;
      ASSERT_NEAR(map.angle_rad[v] * 180 / std::numbers::pi, turn, 4e-3);
      int want = 17;
      if (share >= 2.0 / 3) {
        want = 1 + static_cast<int>((turn + 30) / 60) % 6;
      } else if (share >= 1.0 / 3) {
        want = 7 + static_cast<int>((turn + 30) / 60) % 6;
      } else if (share >= 0.08) {
        want = 13 + static_cast<int>((turn + 45) / 90) % 4;
      }
      const double edge =
          std::min({std::abs(share - 2.0 / 3), std::abs(share - 1.0 / 3), std::abs(share - 0.08)});
      // How far from the border between two sectors.
      const double width = share < 1.0 / 3 ? 90 : 60;
      const double sector = std::abs(std::remainder(turn + width / 2, width));
      if (edge < 1e-4 || sector < 0.01) continue;
      ASSERT_EQ(map.segment[v], want) << share << " " << turn;
    }
  }
  EXPECT_EQ(seen.size(), 17U);
}

TEST(SurfaceMaps, AreNoneWithoutWhatTheyAreMeasuredThrough) {
  const Ventricle ventricle;
  for (const Structure structure : {Structure::LvBlood, Structure::LvMyocardium}) {
    EXPECT_FALSE(surface_map(structure, {ventricle.fields[0]}, ventricle.surfaces, {}));
  }
  EXPECT_FALSE(surface_map(Structure::LvMyocardium, ventricle.fields, {ventricle.surfaces[1]}, {}));
  // The endocardium looks through the distances of the muscle, whether that has a surface or not.
  const MapFrame frame = frame_of(Turned(), {40, 2, 5});
  const auto alone =
      surface_map(Structure::LvBlood, ventricle.fields, {ventricle.surfaces[0]}, frame);
  const auto beside = surface_map(Structure::LvBlood, ventricle.fields, ventricle.surfaces, frame);
  ASSERT_TRUE(alone && beside);
  EXPECT_EQ(alone->thickness_mm, beside->thickness_mm);
  EXPECT_EQ(alone->segment, beside->segment);
  EXPECT_FALSE(surface_map(Structure::RvBlood, ventricle.fields, ventricle.surfaces, {}));
}

}  // namespace
}  // namespace beatlas::mesh
