#include <gtest/gtest.h>

#include "pipeline/mesh/triangle_mesh.h"

namespace beatlas::mesh {
namespace {

TriangleMesh tetrahedron(const Vec3& at, double edge_mm) {
  TriangleMesh out;
  out.points = {at, at + Vec3(edge_mm, 0, 0), at + Vec3(0, edge_mm, 0), at + Vec3(0, 0, edge_mm)};
  out.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return out;
}

TEST(LargestComponent, IsTheOneThatEnclosesMost) {
  TriangleMesh both = tetrahedron({100, 0, 0}, 1);
  const TriangleMesh big = tetrahedron({0, 0, 0}, 3);
  for (const Vec3& p : big.points) both.points.push_back(p);
  for (const Triangle& t : big.triangles) both.triangles.push_back({t[0] + 4, t[1] + 4, t[2] + 4});
  const LargestComponent found = largest_component(both);
  EXPECT_EQ(found.components, 2);
  EXPECT_NEAR(enclosed_ml(found.mesh.points, found.mesh.triangles), 4.5e-3, 1e-12);
  EXPECT_NEAR(found.others_ml, 1.0 / 6000.0, 1e-12);
  EXPECT_TRUE(inspect(found.mesh.points.size(), found.mesh.triangles).closed_manifold);
}

TEST(CotangentNeighbours, OfARegularTetrahedronAreCotOfSixtyDegrees) {
  TriangleMesh mesh;
  mesh.points = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
  const Neighbours neighbours = cotangent_neighbours(mesh);
  EXPECT_EQ(neighbours.first, (std::vector<std::uint32_t>{0, 3, 6, 9, 12}));
  for (double w : neighbours.weight) EXPECT_NEAR(w, 1.0 / std::sqrt(3.0), 1e-12);
}

TEST(LeastAngle, OfKnownTriangles) {
  EXPECT_NEAR(least_angle_deg({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), 45.0, 1e-9);
  EXPECT_NEAR(least_angle_deg({0, 0, 0}, {2, 0, 0}, {0, std::sqrt(12.0), 0}), 30.0, 1e-9);
  EXPECT_EQ(least_angle_deg({0, 0, 0}, {1, 0, 0}, {2, 0, 0}), 0.0);
}

}  // namespace
}  // namespace beatlas::mesh
