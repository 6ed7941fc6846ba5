#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "pipeline/core/parallel.h"
#include "pipeline/mesh/mesh.h"
#include "runtime/base/error.h"
#include "tests/unit/mesh/beating_shapes.h"
#include "tests/unit/mesh/expect_sound.h"

namespace beatlas::mesh::mesh_cycle_tests {
namespace {

using closed_form::beating_field;
using closed_form::Ellipsoid;

FieldCycle ellipsoid_field(int phases) {
  return beating_field(
      [](double share, const Vec3& x) {
        return closed_form::ellipsoid_level(closed_form::beating_ellipsoid(share), x);
      },
      phases, {-32, -34, -48}, {36, 28, 38});
}

void expect_sound_and_as_large(const FieldCycle& field, const SurfaceCycle& surface,
                               double volume_share) {
  expect_sound(surface);
  const MeshQuality quality = measure_quality(surface);
  ASSERT_EQ(quality.phases.size(), field.distance_mm.phases.size());
  for (std::size_t p = 0; p < quality.phases.size(); ++p) {
    SCOPED_TRACE("phase " + std::to_string(p));
    // Facets cut corners, so a mesh is a little small; a mesh inside out would be negative.
    EXPECT_NEAR(quality.phases[p].volume_ml / field.volume_ml[p], 1.0, volume_share);
  }
}

TEST(MeshCycle, OfABeatingEllipsoidLiesOnItInEveryPhase) {
  constexpr int kPhases = 8;
  const FieldCycle field = ellipsoid_field(kPhases);
  StageContext context;
  const SurfaceCycle surface = mesh_cycle(field, {}, context);
  expect_sound_and_as_large(field, surface, 0.003);
  for (int p = 0; p < kPhases; ++p) {
    const double share = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * p / kPhases);
    const Ellipsoid truth = closed_form::beating_ellipsoid(share);
    double vertices_mm = 0;
    double faces_mm = 0;
    const std::vector<Vec3f>& at = surface.positions[static_cast<std::size_t>(p)];
    for (const Vec3f& x : at) vertices_mm += std::abs(truth.distance_mm(x.cast<double>()));
    for (const auto& t : surface.triangles) {
      const Vec3f middle = (at[t[0]] + at[t[1]] + at[t[2]]) / 3;
      faces_mm += std::abs(truth.distance_mm(middle.cast<double>()));
    }
    // Vertices: the field's own error. Faces: 2 mm edges sag by 0.03 mm on a radius of 20 mm.
    EXPECT_LT(vertices_mm / static_cast<double>(at.size()), 0.01);
    EXPECT_LT(faces_mm / static_cast<double>(surface.triangles.size()), 0.05);
    EXPECT_NEAR(
        measure_quality(surface).phases[static_cast<std::size_t>(p)].volume_ml / truth.volume_ml(),
        1.0, 0.004);
  }
}

TEST(MeshCycle, OfTwoOverlappingEllipsoidsIsSound) {
  const FieldCycle field =
      beating_field(closed_form::two_ellipsoids, 6, {-36, -30, -42}, {36, 32, 38});
  StageContext context;
  expect_sound_and_as_large(field, mesh_cycle(field, {}, context), 0.005);
}

TEST(MeshCycle, OfAVentricleOpenAtItsBaseFollowsTheBaseDown) {
  const FieldCycle field = beating_field(closed_form::cup, 6, {-44, -44, -76}, {44, 44, 38});
  StageContext context;
  const SurfaceCycle surface = mesh_cycle(field, {}, context);
  expect_sound_and_as_large(field, surface, 0.005);
  // A vertex of the side wall half-way up goes down with the wall, not merely inward: the base
  // plane sinks by 14 mm, the apex rests.
  double sunk_mm = 0;
  int count = 0;
  for (std::size_t v = 0; v < surface.positions[0].size(); ++v) {
    const Vec3f& x = surface.positions[0][v];
    if (std::abs(x.z() + 19) > 2 || x.head<2>().norm() < 31) continue;
    sunk_mm += x.z() - surface.positions[3][v].z();
    ++count;
  }
  ASSERT_GT(count, 50);
  EXPECT_GT(sunk_mm / count, 3.0);
  EXPECT_LT(sunk_mm / count, 11.0);
}

TEST(MeshCycle, OfACrescentWithSteepMotionIsSound) {
  // Six phases only: the base goes by up to 11 mm from one to the next.
  const FieldCycle field = beating_field(closed_form::crescent, 6, {-12, -52, -72}, {68, 52, 40});
  StageContext context;
  expect_sound_and_as_large(field, mesh_cycle(field, {}, context), 0.005);
}

TEST(MeshCycle, TheCycleClosesWithoutASeam) {
  constexpr std::size_t kPhases = 8;
  const FieldCycle field = ellipsoid_field(kPhases);
  StageContext context;
  MeshOptions options;
  options.reference_phase = 3;
  const SurfaceCycle surface = mesh_cycle(field, options, context);
  expect_sound_and_as_large(field, surface, 0.003);
  // The motion is even in time about phase 4, so the steps into and out of it match, and no step
  // is longer than the surface's own largest (4 * sin(2 pi / 8) mm, plus the drift of its centre).
  double longest_mm = 0;
  double uneven_mm = 0;
  for (std::size_t v = 0; v < surface.positions[0].size(); ++v) {
    for (std::size_t p = 0; p < kPhases; ++p) {
      longest_mm = std::max<double>(
          longest_mm, (surface.positions[(p + 1) % kPhases][v] - surface.positions[p][v]).norm());
      uneven_mm = std::max<double>(
          uneven_mm,
          (surface.positions[p][v] - surface.positions[(kPhases - p) % kPhases][v]).norm());
    }
  }
  EXPECT_LT(longest_mm, 4.0);
  EXPECT_LT(uneven_mm, 0.1);
}

TEST(MeshCycle, TheNumberOfThreadsChangesNoBit) {
  const FieldCycle field = ellipsoid_field(4);
  StageContext context;
  set_thread_count(1);
  const SurfaceCycle alone = mesh_cycle(field, {}, context);
  set_thread_count(4);
  const SurfaceCycle together = mesh_cycle(field, {}, context);
  set_thread_count(0);
  EXPECT_EQ(alone.triangles, together.triangles);
  EXPECT_EQ(alone.positions, together.positions);
}

TEST(MeshCycle, EdgesFollowTheSamplesOfTheField) {
  EXPECT_EQ(triangle_edge_mm(1, {}), 2);
  EXPECT_EQ(triangle_edge_mm(1.5, {}), 2);
  EXPECT_DOUBLE_EQ(triangle_edge_mm(2.25, {}), 2.5);
  MeshOptions told;
  told.edge_mm = 1.5;
  EXPECT_EQ(triangle_edge_mm(2.25, told), 1.5);
}

TEST(MeshCycle, EdgesAreAsLongAsAskedFor) {
  const FieldCycle field = ellipsoid_field(1);
  StageContext context;
  for (double edge_mm : {1.5, 3.0, 5.0}) {
    MeshOptions options;
    options.edge_mm = edge_mm;
    const MeshQuality quality = measure_quality(mesh_cycle(field, options, context));
    // Isotropic remeshing keeps edges between 4/5 and 4/3 of the target.
    EXPECT_NEAR(quality.phases[0].mean_edge_mm / edge_mm, 1.0, 0.2);
  }
}

TEST(MeshCycle, KeepsTheLargestPieceAndSaysSo) {
  const FieldCycle field = beating_field(
      [](double, const Vec3& x) {
        return std::min((x - Vec3(-5, 0, 0)).norm() - 14.0, (x - Vec3(20, 0, 0)).norm() - 4.0);
      },
      2, {-28, -24, -24}, {34, 24, 24}, field::Handles::Keep);
  StageContext context;
  std::string log;
  context.warn_sink = [&](std::string_view line) { log += line; };
  const SurfaceCycle surface = mesh_cycle(field, {}, context);
  EXPECT_NE(log.find("falls into 2 pieces"), std::string::npos) << log;
  EXPECT_EQ(measure_quality(surface).euler_number, 2);
  for (const Vec3f& x : surface.positions[1]) {
    ASSERT_NEAR((x - Vec3f(-5, 0, 0)).norm(), 14.0F, 0.05F);
  }
}

TEST(MeshCycle, ARingKeepsItsHandleAndSaysSo) {
  const FieldCycle field = beating_field(
      [](double share, const Vec3& x) {
        return std::hypot(std::hypot(x.x(), x.y()) - 18 + 2 * share, x.z()) - 7.0;
      },
      4, {-34, -34, -16}, {34, 34, 16}, field::Handles::Keep);
  StageContext context;
  std::string log;
  context.warn_sink = [&](std::string_view line) { log += line; };
  const MeshQuality quality = measure_quality(mesh_cycle(field, {}, context));
  EXPECT_TRUE(quality.closed_manifold);
  EXPECT_EQ(quality.euler_number, 0);
  EXPECT_NE(log.find("1 handle"), std::string::npos) << log;
  // Facets of 2 mm sag by 0.04 mm on average on a tube of 7 mm radius: 2 * 0.04 / 7 of the volume.
  const double want_ml = 2 * std::pow(std::numbers::pi, 2) * 16 * 49 * 1e-3;
  EXPECT_NEAR(quality.phases[2].volume_ml / want_ml, 1.0, 0.015);
}

ErrorCode code_of(const FieldCycle& field, const MeshOptions& options = {}) {
  StageContext context;
  try {
    (void)mesh_cycle(field, options, context);
  } catch (const Error& error) {
    return error.code();
  }
  ADD_FAILURE() << "no error";
  return ErrorCode::Machine;
}

TEST(MeshCycle, BadFieldsAndOptionsAreRefused) {
  const FieldCycle good = beating_field([](double, const Vec3& x) { return x.norm() - 8.0; }, 2,
                                        {-16, -16, -16}, {16, 16, 16});
  FieldCycle empty_phase = good;
  empty_phase.distance_mm.phases[1].assign(good.distance_mm.grid.count(), 6.0F);
  EXPECT_EQ(code_of(empty_phase), ErrorCode::InvalidInput);

  FieldCycle none = good;
  none.distance_mm.phases.clear();
  EXPECT_EQ(code_of(none), ErrorCode::InvalidInput);

  FieldCycle short_phase = good;
  short_phase.distance_mm.phases[0].pop_back();
  EXPECT_EQ(code_of(short_phase), ErrorCode::InvalidInput);

  FieldCycle cut_open = good;  // inside up to the border of the lattice
  for (int n = 0; n < good.distance_mm.grid.size[0]; ++n) {
    cut_open.distance_mm.phases[0][cut_open.distance_mm.grid.offset(n, 12, 12)] = -1.0F;
  }
  EXPECT_EQ(code_of(cut_open), ErrorCode::Quality);

  MeshOptions options;
  options.edge_mm = 0.1;
  EXPECT_EQ(code_of(good, options), ErrorCode::Usage);
  options = {};
  options.reference_phase = 2;
  EXPECT_EQ(code_of(good, options), ErrorCode::Usage);
  options = {};
  options.edge_mm = 10;  // longer than the ball's radius
  EXPECT_EQ(code_of(good, options), ErrorCode::Quality);
}

}  // namespace
}  // namespace beatlas::mesh::mesh_cycle_tests
