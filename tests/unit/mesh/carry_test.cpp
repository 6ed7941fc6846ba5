#include "pipeline/mesh/carry.h"

#include <gtest/gtest.h>

#include "pipeline/field/surface.h"
#include "tests/unit/mesh/beating_shapes.h"

namespace beatlas::mesh {
namespace {

TEST(Carrier, MovesAShiftedBallAsAWhole) {
  // Along normals alone the sides of the ball would stay where they are; what changes least over
  // the mesh is the shift itself, which is known exactly.
  const Vec3 shift(0, 0, 5);
  const FieldCycle field = closed_form::beating_field(
      [&](double share, const Vec3& x) { return (x - share * shift).norm() - 15.0; }, 2,
      {-24, -24, -24}, {24, 24, 30});
  const Grid& grid = field.distance_mm.grid;
  field::TriangleSoup soup = field::extract_surface(field, 0);
  const field::Interpolant start(grid, field.distance_mm.phases[0]);
  const field::Interpolant end(grid, field.distance_mm.phases[1]);
  TriangleMesh mesh = remeshed({soup.points, soup.triangles}, 2.0);
  relax_on_surface(mesh, start, 3);
  const Carrier carrier(mesh);
  std::vector<Vec3> moved =
      carrier.carry(mesh.points, grid, field.distance_mm.phases[0], field.distance_mm.phases[1]);
  for (Vec3& x : moved) x = end.project_to_zero(x, 1.0);
  for (std::size_t v = 0; v < moved.size(); ++v) {
    ASSERT_LT((moved[v] - mesh.points[v] - shift).norm(), 0.2);
    ASSERT_NEAR((moved[v] - shift).norm(), 15.0, 0.02);
  }
}

}  // namespace
}  // namespace beatlas::mesh
