// Shapes at the limit of the lattice, meshed through the cycle.

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "pipeline/field/repair_topology.h"
#include "pipeline/mesh/mesh.h"
#include "runtime/base/error.h"
#include "tests/unit/mesh/beating_shapes.h"
#include "tests/unit/mesh/expect_sound.h"

namespace beatlas::mesh {
namespace {

using closed_form::beating_field;
using closed_form::BeatingLevel;

constexpr double kVoxelMm = 1.5;  // of the field, FieldOptions' default

// Two arms joined at one end, `gap_mm` apart.
BeatingLevel hairpin(double gap_mm) {
  return [gap_mm](double share, const Vec3& x) {
    const double outer = closed_form::ellipsoid_level({{0, 0, 0}, {22 - 2 * share, 14, 12}}, x);
    const double slit = std::max(std::abs(x.z()) - 0.5 * gap_mm, -x.x() - 10);
    return std::max(outer, -slit);
  };
}

TEST(HardCases, TwoWallsOneAndAHalfVoxelsApart) {
  StageContext context;
  expect_sound(mesh_cycle(beating_field(hairpin(1.5 * kVoxelMm), 4, {-30, -22, -20}, {30, 22, 20}),
                          {}, context));
}

TEST(HardCases, AGapOfOneVoxel) {
  StageContext context;
  expect_sound(
      mesh_cycle(beating_field(hairpin(kVoxelMm), 4, {-30, -22, -20}, {30, 22, 20}), {}, context));
}

TEST(HardCases, ASurfaceThatTheWorkspacesBorderCuts) {
  StageContext context;
  const FieldCycle field = beating_field(
      [](double share, const Vec3& x) { return (x - Vec3(0, 0, 4)).norm() - 16 + 2 * share; }, 4,
      {-24, -24, -10}, {24, 24, 30});
  const SurfaceCycle surface = mesh_cycle(field, {}, context);
  expect_sound(surface);
  for (const Vec3f& x : surface.positions[0]) ASSERT_GT(x.z(), -12.0F);
}

TEST(HardCases, ACavityThatNearlyCloses) {
  // 20 mm across at end diastole in its narrow way, 5 mm at end systole: three voxels.
  StageContext context;
  const FieldCycle field = beating_field(
      [](double share, const Vec3& x) {
        return closed_form::ellipsoid_level(
            {{0, 0, 0}, {10 - 7.5 * share, 14 - 8 * share, 30 - 8 * share}}, x);
      },
      6, {-18, -22, -38}, {18, 22, 38});
  expect_sound(mesh_cycle(field, {}, context));
}

TEST(HardCases, TheFarCornerOfTheWorkspaceIsLikeAnyPlace) {
  StageContext context;
  const Vec3 corner(216, 216, 156);  // whole voxels from the other
  const auto at = [&](const Vec3& place) {
    return mesh_cycle(beating_field(
                          [&](double share, const Vec3& x) {
                            return closed_form::ellipsoid_level(
                                closed_form::beating_ellipsoid(share), x - place);
                          },
                          4, place + Vec3(-32, -34, -48), place + Vec3(36, 28, 38)),
                      {}, context);
  };
  const SurfaceCycle near = at(Vec3::Zero());
  const SurfaceCycle far = at(corner);
  expect_sound(far);
  EXPECT_NEAR(measure_quality(far).phases[2].volume_ml / measure_quality(near).phases[2].volume_ml,
              1.0, 1e-3);
}

TEST(HardCases, APhaseWithoutItsStructureIsRefusedByName) {
  FieldCycle field = beating_field([](double, const Vec3& x) { return x.norm() - 10.0; }, 3,
                                   {-18, -18, -18}, {18, 18, 18});
  field.structure = Structure::RvBlood;
  StageContext context;
  for (const float value : {6.0F, -15.0F}) {
    FieldCycle broken = field;
    broken.distance_mm.phases[1].assign(field.distance_mm.grid.count(), value);
    try {
      (void)mesh_cycle(broken, {}, context);
      FAIL() << "not refused";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
      EXPECT_NE(std::string(error.what()).find("phase 1 of rv_blood has no surface"),
                std::string::npos)
          << error.what();
    }
  }
}

TEST(HardCases, AnEmptyStructureIsRefusedByName) {
  FieldCycle field = beating_field([](double, const Vec3& x) { return x.norm() - 10.0; }, 3,
                                   {-18, -18, -18}, {18, 18, 18});
  field.structure = Structure::RvBlood;
  for (std::vector<float>& phase : field.distance_mm.phases) phase.assign(phase.size(), 6.0F);
  StageContext context;
  try {
    (void)mesh_cycle(field, {}, context);
    FAIL() << "not refused";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
    EXPECT_NE(std::string(error.what()).find("rv_blood has no surface"), std::string::npos);
  }
}

TEST(HardCases, AHandleOfOnePhaseIsClosedInIt) {
  // A hole opens in a thin wall at end systole and closes again.
  StageContext context;
  std::string log;
  context.warn_sink = [&](std::string_view line) { log += line; };
  FieldCycle field = beating_field(
      [](double share, const Vec3& x) {
        const double cup = std::max({x.norm() - 20, 15 - (x - Vec3(0, 0, 2)).norm(), x.z() - 8});
        return std::max(cup,
                        4.5 * share - 2 - std::hypot(x.y(), x.z() + 4) + (x.x() > 0 ? 0 : -99));
      },
      4, {-28, -28, -28}, {28, 28, 20}, field::Handles::Keep);
  field::repair_topology(field, context);
  const SurfaceCycle surface = mesh_cycle(field, {}, context);
  expect_sound(surface);
  EXPECT_NE(log.find("was mended in 1 of 4 phases"), std::string::npos) << log;
}

}  // namespace
}  // namespace beatlas::mesh
