#include "pipeline/mesh/cycle_fit.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "pipeline/field/surface.h"
#include "pipeline/mesh/mesh.h"
#include "tests/unit/mesh/beating_shapes.h"

namespace beatlas::mesh {
namespace {

constexpr int kPhases = 12;

// A ball that beats, its mesh carried exactly: every vertex goes along its radius.
struct BeatingBall {
  BeatingBall()
      : field(closed_form::beating_field(
            [](double share, const Vec3& x) { return x.norm() - radius_mm(share); }, kPhases,
            {-26, -26, -26}, {26, 26, 26})) {
    for (const auto& samples : field.distance_mm.phases) {
      surfaces.emplace_back(field.distance_mm.grid, samples);
    }
    field::TriangleSoup soup = field::extract_surface(field, 0);
    TriangleMesh mesh = remeshed({soup.points, soup.triangles}, 2.0);
    relax_on_surface(mesh, surfaces[0], 3);
    triangles = mesh.triangles;
    for (int p = 0; p < kPhases; ++p) {
      const double share = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * p / kPhases);
      std::vector<Vec3>& at = exact.emplace_back();
      for (const Vec3& x : mesh.points) at.push_back(radius_mm(share) * x.normalized());
    }
  }
  static double radius_mm(double share) { return 18 - 4 * share; }
  [[nodiscard]] MeshQuality quality(const Cycle& cycle, const std::vector<Triangle>& of) const {
    SurfaceCycle surface;
    surface.triangles = of;
    for (const std::vector<Vec3>& phase : cycle) {
      std::vector<Vec3f>& at = surface.positions.emplace_back();
      for (const Vec3& x : phase) at.push_back(x.cast<float>());
    }
    return measure_quality(surface);
  }
  FieldCycle field;
  std::vector<field::Interpolant> surfaces;
  std::vector<Triangle> triangles;
  Cycle exact;
};

TEST(CycleFit, CountsWhatAMeshLacksBesideThinTriangles) {
  const BeatingBall ball;
  const CycleFit fit(ball.triangles, ball.surfaces, 2.0);
  EXPECT_EQ(fit.flawed_share(ball.exact), 0);
  // In one phase a cap of 30 degrees is cut off flat: its triangles lie off the ball, those by more
  // than 1 mm from which it stood out by more than that.
  Cycle cut = ball.exact;
  const double at_mm = BeatingBall::radius_mm(0) * std::cos(std::numbers::pi / 6);
  for (Vec3& x : cut[0]) x.z() = std::min(x.z(), at_mm);
  const double lost = (1 - (at_mm + 1) / BeatingBall::radius_mm(0)) / 2;
  EXPECT_NEAR(fit.flawed_share(cut), 10 * lost / kPhases, 0.3 * lost);
}

TEST(CycleFit, TakesJitterOffAndLeavesMotion) {
  const BeatingBall ball;
  CycleFit fit(ball.triangles, ball.surfaces, 2.0);
  Cycle still = ball.exact;
  fit.calm(still);
  Cycle shaken = ball.exact;
  std::mt19937 random(3);
  std::normal_distribution<double> any(0, 0.2);
  for (std::vector<Vec3>& phase : shaken) {
    for (Vec3& x : phase) {
      const Vec3 way(any(random), any(random), any(random));
      x += way - x.normalized().dot(way) * x.normalized();
    }
  }
  const double before_mm = ball.quality(shaken, ball.triangles).tangential_jitter_mm;
  fit.calm(shaken);
  const MeshQuality after = ball.quality(shaken, ball.triangles);
  EXPECT_GT(before_mm, 0.1);
  EXPECT_LT(after.tangential_jitter_mm, before_mm / 2.5);
  double moved_mm = 0;
  double off_mm = 0;
  for (std::size_t p = 0; p < shaken.size(); ++p) {
    for (std::size_t v = 0; v < shaken[p].size(); ++v) {
      moved_mm = std::max(moved_mm, (still[p][v] - ball.exact[p][v]).norm());
      off_mm = std::max(off_mm, std::abs(ball.surfaces[p].value(shaken[p][v])));
    }
  }
  EXPECT_LT(moved_mm, 0.03);  // the field's own error and the filter's at the first harmonic
  EXPECT_LT(off_mm, 0.01);
}

TEST(CycleFit, ThinAndTurnedTrianglesAreEvenedOutInEveryPhase) {
  const BeatingBall ball;
  CycleFit fit(ball.triangles, ball.surfaces, 2.0);
  Cycle cycle = ball.exact;
  // One vertex far beyond its ring in one phase: its triangles turn over there.
  const std::size_t v = ball.triangles[100][0];
  cycle[5][v] = cycle[5][v].norm() *
                (cycle[5][v] + 4.0 * Vec3(1, 2, 3).cross(cycle[5][v]).normalized()).normalized();
  ASSERT_GT(ball.quality(cycle, ball.triangles).phases[5].flipped_triangles, 0);
  fit.settle(cycle);
  const MeshQuality after = ball.quality(cycle, fit.triangles());
  EXPECT_TRUE(after.closed_manifold);
  EXPECT_EQ(after.euler_number, 2);
  for (const PhaseQuality& phase : after.phases) {
    EXPECT_EQ(phase.flipped_triangles, 0);
    EXPECT_EQ(phase.self_intersections, 0);
    EXPECT_GT(phase.least_angle_deg, 15.9);
  }
}

TEST(CycleFit, VerticesThatASlitLeftBehindComeOutOfIt) {
  const BeatingBall ball;
  CycleFit fit(ball.triangles, ball.surfaces, 2.0);
  Cycle cycle = ball.exact;
  // As where in other phases there was a pocket, 10 mm deep: too far from any surface to find it.
  for (const std::size_t p : {5, 6}) {
    for (Vec3& x : cycle[p]) {
      const double near_pole = std::hypot(x.x(), x.y());
      if (x.z() > 0 && near_pole < 4) x.z() -= std::min(10.0, 5 * (4 - near_pole));
    }
  }
  fit.leave_slits(cycle);
  fit.settle(cycle);
  const MeshQuality after = ball.quality(cycle, fit.triangles());
  EXPECT_TRUE(after.closed_manifold);
  for (std::size_t p = 0; p < cycle.size(); ++p) {
    SCOPED_TRACE(p);
    double off_mm = 0;
    for (const Vec3& x : cycle[p]) off_mm = std::max(off_mm, std::abs(ball.surfaces[p].value(x)));
    EXPECT_LT(off_mm, 0.01);
    EXPECT_EQ(after.phases[p].flipped_triangles, 0);
    EXPECT_EQ(after.phases[p].self_intersections, 0);
    EXPECT_GT(after.phases[p].least_angle_deg, 10.0);
  }
}

TEST(CycleFit, SheetsThatCrossAreParted) {
  const BeatingBall ball;
  CycleFit fit(ball.triangles, ball.surfaces, 2.0);
  Cycle cycle = ball.exact;
  // A dent deeper than the ball, through its other side.
  for (Vec3& x : cycle[4]) {
    const double near_pole = std::hypot(x.x(), x.y());
    if (x.z() > 0 && near_pole < 4) x.z() -= (1 - near_pole / 4) * 40;
  }
  const MeshQuality before = ball.quality(cycle, ball.triangles);
  ASSERT_GT(before.phases[4].self_intersections, 0);
  EXPECT_EQ(fit.mend(cycle), 0);
  const MeshQuality after = ball.quality(cycle, fit.triangles());
  EXPECT_TRUE(after.closed_manifold);
  for (const PhaseQuality& phase : after.phases) {
    EXPECT_EQ(phase.self_intersections, 0);
    EXPECT_EQ(phase.flipped_triangles, 0);
    EXPECT_GT(phase.least_angle_deg, 10.9);
  }
}

TEST(CycleFit, ALumpIsDrawnApart) {
  // A ball with a finger of 12 mm, which the second phase lacks.
  constexpr double kBallMm = 14;
  constexpr double kFingerMm = 5;
  const FieldCycle field = closed_form::beating_field(
      [](double share, const Vec3& x) {
        const Vec3 along(0, 0, std::clamp(x.z(), 5.0, 21.0 - 12 * share));
        return std::min(x.norm() - kBallMm, (x - along).norm() - kFingerMm);
      },
      2, {-20, -20, -20}, {20, 20, 32});
  std::vector<field::Interpolant> surfaces;
  for (const auto& samples : field.distance_mm.phases) {
    surfaces.emplace_back(field.distance_mm.grid, samples);
  }
  field::TriangleSoup soup = field::extract_surface(field, 0);
  TriangleMesh mesh = remeshed({soup.points, soup.triangles}, 2.0);
  relax_on_surface(mesh, surfaces[0], 3);
  // Its vertices are left in a grain, which a package's rounding would fold in any way.
  Cycle cycle{mesh.points, mesh.points};
  std::mt19937 random(5);
  std::normal_distribution<double> any(0, 0.02);
  int lump = 0;
  for (Vec3& x : cycle[1]) {
    if (x.z() < 14) continue;
    x = Vec3(any(random), any(random), kBallMm + any(random));
    ++lump;
  }
  ASSERT_GT(lump, 100);
  CycleFit fit(mesh.triangles, surfaces, 2.0);
  EXPECT_EQ(fit.mend(cycle), 0);
  for (const std::vector<Vec3>& points : cycle) {
    double least_deg = 180;
    double least_mm = 1e9;
    for (const Triangle& t : fit.triangles()) {
      least_deg = std::min(least_deg, least_angle_deg(points[t[0]], points[t[1]], points[t[2]]));
      least_mm = std::min(least_mm, (points[t[1]] - points[t[0]]).norm());
    }
    EXPECT_GT(least_deg, 10.9);
    EXPECT_GT(least_mm, 0.02);  // shorter ones could be turned over when both ends are rounded
  }
}

TEST(CycleFit, TheFilterKeepsMotionAndTakesTheQuickest) {
  EXPECT_GT(kept_of_harmonic(4, 15), 0.95);
  EXPECT_LT(kept_of_harmonic(7, 15), 0.35);
  EXPECT_EQ(kept_of_harmonic(0, 10), 1.0);
}

}  // namespace
}  // namespace beatlas::mesh
