#include "pipeline/mesh/levels.h"

#include <cmath>

#include <gtest/gtest.h>

#include "pipeline/core/parallel.h"
#include "runtime/base/error.h"
#include "tests/unit/mesh/beating_shapes.h"
#include "tests/unit/mesh/expect_sound.h"

namespace beatlas::mesh {
namespace {

constexpr int kPhases = 6;

/// A beating cup, thin at its rim, meshed with edges of 2 mm.
struct Cup {
  Cup()
      : field(
            closed_form::beating_field(closed_form::cup, kPhases, {-44, -44, -76}, {44, 44, 38})) {
    StageContext context;
    surface = mesh_cycle(field, {}, context);
  }
  [[nodiscard]] SurfaceCycle level(double edge_mm) const {
    StageContext context;
    MeshOptions options;
    options.edge_mm = edge_mm;
    return level_of_detail(surface, field, options, context);
  }
  FieldCycle field;
  SurfaceCycle surface;
};

const Cup& cup() {
  static const Cup made;
  return made;
}

TEST(LevelOfDetail, IsSoundInEveryPhaseAndOnItsField) {
  const SurfaceError made = error_against(cup().field, cup().surface);
  EXPECT_LT(made.mean_mm, 0.06);
  for (const double edge_mm : {1.25, 4.0}) {
    SCOPED_TRACE(edge_mm);
    const SurfaceCycle level = cup().level(edge_mm);
    expect_sound(level);
    const double ratio = static_cast<double>(level.triangles.size()) /
                         static_cast<double>(cup().surface.triangles.size());
    // Triangles go with the square of their edges.
    EXPECT_NEAR(std::log(ratio), 2 * std::log(2.0 / edge_mm), 0.35);
    const SurfaceError error = error_against(cup().field, level);
    // Edges cut off e^2 / 8 r for the most part, 0.1 mm at 4 mm on r of 20 mm; rims add to it.
    EXPECT_LT(error.mean_mm, edge_mm < 2 ? made.mean_mm : 0.12);
    EXPECT_LT(error.worst_phase_mm, 1.3 * error.mean_mm);
    EXPECT_LE(std::abs(error.bias_mm), error.mean_mm);
  }
}

TEST(LevelOfDetail, GoesWithTheSurfaceItIsMadeOf) {
  const SurfaceCycle coarse = cup().level(4.0);
  // What a vertex has done by end-systole is what the nearest vertex of the surface has: those are
  // at most a good millimetre apart, and motion changes by a tenth of that.
  constexpr std::size_t kSystole = kPhases / 2;
  double off_mm = 0;
  for (std::size_t v = 0; v < coarse.positions[0].size(); ++v) {
    const Vec3f& x = coarse.positions[0][v];
    std::size_t nearest = 0;
    for (std::size_t n = 1; n < cup().surface.positions[0].size(); ++n) {
      if ((cup().surface.positions[0][n] - x).squaredNorm() <
          (cup().surface.positions[0][nearest] - x).squaredNorm()) {
        nearest = n;
      }
    }
    const Vec3f moved = coarse.positions[kSystole][v] - x;
    const Vec3f there =
        cup().surface.positions[kSystole][nearest] - cup().surface.positions[0][nearest];
    off_mm += static_cast<double>((moved - there).norm());
  }
  EXPECT_LT(off_mm / static_cast<double>(coarse.positions[0].size()), 0.35);
}

TEST(LevelOfDetail, HasTheSameBitsForAnyNumberOfThreads) {
  set_thread_count(1);
  const SurfaceCycle alone = cup().level(5.0);
  set_thread_count(3);
  const SurfaceCycle together = cup().level(5.0);
  set_thread_count(0);
  EXPECT_EQ(alone.triangles, together.triangles);
  EXPECT_EQ(alone.positions, together.positions);
}

TEST(LevelOfDetail, RefusesWhatItCannotBeMadeOf) {
  StageContext context;
  const auto code_of = [&](const SurfaceCycle& surface, const MeshOptions& options) {
    try {
      (void)level_of_detail(surface, cup().field, options, context);
    } catch (const Error& error) {
      return error.code();
    }
    ADD_FAILURE() << "accepted";
    return ErrorCode::Machine;
  };
  MeshOptions options;
  options.edge_mm = 0.1;
  EXPECT_EQ(code_of(cup().surface, options), ErrorCode::Usage);
  options.edge_mm = 4;
  SurfaceCycle shorter = cup().surface;
  shorter.positions.pop_back();
  EXPECT_EQ(code_of(shorter, options), ErrorCode::InvalidInput);
}

TEST(ErrorAgainstAField, IsWhatAShiftMakesIt) {
  // Put 0.5 mm outward: the mean is the shift, and so is the bias.
  const FieldCycle ball = closed_form::beating_field(
      [](double, const Vec3& x) { return x.norm() - 15; }, 1, {-24, -24, -24}, {24, 24, 24});
  StageContext context;
  SurfaceCycle surface = mesh_cycle(ball, {}, context);
  const SurfaceError before = error_against(ball, surface);
  EXPECT_LT(before.mean_mm, 0.06);
  EXPECT_LT(before.bias_mm, 0);  // chords lie inside
  for (Vec3f& x : surface.positions[0]) x += 0.5F * x.normalized();
  const SurfaceError after = error_against(ball, surface);
  EXPECT_NEAR(after.bias_mm - before.bias_mm, 0.5, 0.01);
  EXPECT_NEAR(after.mean_mm, after.bias_mm, 1e-9);
  EXPECT_NEAR(after.worst_phase_mm, after.mean_mm, 1e-9);
}

TEST(ErrorAgainstAField, KnowsWhatTrianglesCutOffThoughTheirVerticesLieOnTheSurface) {
  const FieldCycle ball = closed_form::beating_field(
      [](double, const Vec3& x) { return x.norm() - 15; }, 1, {-24, -24, -24}, {24, 24, 24});
  SurfaceCycle octahedron;
  octahedron.positions = {
      {{15, 0, 0}, {-15, 0, 0}, {0, 15, 0}, {0, -15, 0}, {0, 0, 15}, {0, 0, -15}}};
  octahedron.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                          {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  // The same four places of a triangle, on the ball's closed form.
  const Vec3 middle(5, 5, 5);
  double cut_off_mm = (15 - middle.norm()) / 4;
  for (int n = 0; n < 3; ++n) cut_off_mm += (15 - (middle + 15 * Vec3::Unit(n)).norm() / 2) / 4;
  const SurfaceError error = error_against(ball, octahedron);
  EXPECT_NEAR(error.mean_mm, cut_off_mm, 0.05);
  EXPECT_NEAR(error.bias_mm, -cut_off_mm, 0.05);
}

}  // namespace
}  // namespace beatlas::mesh
