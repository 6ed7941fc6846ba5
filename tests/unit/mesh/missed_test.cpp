#include "pipeline/mesh/missed.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "pipeline/field/surface.h"
#include "tests/unit/mesh/beating_shapes.h"

namespace beatlas::mesh {
namespace {

constexpr double kReachMm = 1;

FieldCycle field_of(const closed_form::BeatingLevel& level) {
  return closed_form::beating_field(level, 1, {-12, -12, -12}, {21, 12, 12});
}

double ball(const Vec3& x, double radius, double at) {
  return (x - Vec3(at, 0, 0)).norm() - radius;
}

/// What the mesh of `meshed` misses of the surface of `whole`.
double missed_of(const closed_form::BeatingLevel& whole, const closed_form::BeatingLevel& meshed) {
  const FieldCycle field = field_of(whole);
  const field::TriangleSoup mesh = field::extract_surface(field_of(meshed), 0);
  return missed_share(field.distance_mm.grid, field.distance_mm.phases[0], mesh.points,
                      mesh.triangles, kReachMm);
}

double one_ball(double, const Vec3& x) { return ball(x, 10, 0); }

TEST(MissedShare, IsNoneOfASurfaceThatIsMeshed) { EXPECT_EQ(missed_of(one_ball, one_ball), 0); }

TEST(MissedShare, IsThatOfAPartThatTheMeshNeverEntered) {
  // A ball of 6 mm whose centre lies 13 mm from that of one of 10 mm, alone in the mesh. By the
  // law of cosines a share of (1 - c) / 2 of a sphere lies beyond the cosine c of an angle.
  const auto cosine = [](double radius, double from_other) {
    return (from_other * from_other - 13 * 13 - radius * radius) / (2 * 13 * radius);
  };
  const double small_mm2 = 36 * (1 - cosine(6, 10)) / 2;
  const double large_mm2 = 100 * (1 - cosine(10, 6)) / 2;
  const double beyond_mm2 = 36 * (1 - cosine(6, 10 + kReachMm)) / 2;
  // Lines of a lattice meet slanted parts more often, which changes the share by .003; with no
  // reach at all it would be .24 for .22.
  const double share = missed_of(
      [](double, const Vec3& x) { return std::min(ball(x, 10, 0), ball(x, 6, 13)); }, one_ball);
  EXPECT_NEAR(share, beyond_mm2 / (small_mm2 + large_mm2), 0.015);
}

TEST(MissedShare, LeavesPitsThatAreBridgedOut) {
  const auto pitted = [](double, const Vec3& x) {
    return std::max(ball(x, 10, 0), 4 - std::hypot(x.y(), x.z()));
  };
  EXPECT_EQ(missed_of(pitted, one_ball), 0);
}

}  // namespace
}  // namespace beatlas::mesh
