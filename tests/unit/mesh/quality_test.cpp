#include <gtest/gtest.h>

#include "pipeline/mesh/mesh.h"

namespace beatlas::mesh {
namespace {

SurfaceCycle octahedron() {
  SurfaceCycle out;
  out.positions = {{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}};
  out.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                   {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  return out;
}

TEST(MeasureQuality, OfAnOctahedronIsKnownByHand) {
  const MeshQuality quality = measure_quality(octahedron());
  EXPECT_TRUE(quality.closed_manifold);
  EXPECT_EQ(quality.euler_number, 2);
  ASSERT_EQ(quality.phases.size(), 1U);
  EXPECT_NEAR(quality.phases[0].least_angle_deg, 60.0, 1e-5);  // positions are float
  EXPECT_NEAR(quality.phases[0].mean_edge_mm, std::sqrt(2.0), 1e-6);
  EXPECT_NEAR(quality.phases[0].volume_ml, 4.0 / 3.0 * 1e-3, 1e-9);
  EXPECT_EQ(quality.phases[0].flipped_triangles, 0);
  EXPECT_EQ(quality.phases[0].self_intersections, 0);
}

TEST(MeasureQuality, SeesATipPushedThroughTheOtherSide) {
  SurfaceCycle surface = octahedron();
  // Half-way down the lower pyramid is |x| + |y| <= 0.5.
  surface.positions[0][4] = {0.3F, 0.4F, -0.5F};
  const MeshQuality quality = measure_quality(surface);
  EXPECT_TRUE(quality.closed_manifold);
  EXPECT_GT(quality.phases[0].self_intersections, 0);
}

TEST(MeasureQuality, AMeshInsideOutHasANegativeVolume) {
  SurfaceCycle surface = octahedron();
  for (auto& t : surface.triangles) std::swap(t[0], t[1]);
  const MeshQuality quality = measure_quality(surface);
  EXPECT_TRUE(quality.closed_manifold);
  EXPECT_NEAR(quality.phases[0].volume_ml, -4.0 / 3.0 * 1e-3, 1e-9);
}

TEST(MeasureQuality, SeesAFoldedTriangle) {
  // A finely divided bottom and one vertex of the rim drawn across its neighbours.
  SurfaceCycle surface;
  constexpr std::uint32_t kSides = 12;
  std::vector<Vec3f> points;
  for (std::uint32_t n = 0; n < kSides; ++n) {
    const float angle = 6.2831853F * static_cast<float>(n) / kSides;
    points.emplace_back(std::cos(angle), std::sin(angle), 0.0F);
  }
  points.emplace_back(0.0F, 0.0F, 0.2F);
  points.emplace_back(0.0F, 0.0F, -0.2F);
  for (std::uint32_t n = 0; n < kSides; ++n) {
    surface.triangles.push_back({n, (n + 1) % kSides, kSides});
    surface.triangles.push_back({(n + 1) % kSides, n, kSides + 1});
  }
  surface.positions.push_back(points);
  EXPECT_EQ(measure_quality(surface).phases[0].flipped_triangles, 0);
  // Beyond its second neighbour, along the rim: the triangles between turn over.
  surface.positions[0][0] = points[2] * 1.2F;
  EXPECT_GT(measure_quality(surface).phases[0].flipped_triangles, 0);
}

TEST(MeasureQuality, SeesWhatIsNoClosedManifold) {
  SurfaceCycle open = octahedron();
  open.triangles.pop_back();
  EXPECT_FALSE(measure_quality(open).closed_manifold);

  SurfaceCycle turned = octahedron();
  std::swap(turned.triangles[0][0], turned.triangles[0][1]);
  EXPECT_FALSE(measure_quality(turned).closed_manifold);

  // Two octahedra that share a tip: every edge has two faces, the tip two fans.
  SurfaceCycle pinched = octahedron();
  const SurfaceCycle other = octahedron();
  for (std::size_t v = 0; v < 5; ++v) {
    pinched.positions[0].push_back(other.positions[0][v] + Vec3f(0, 0, 2));
  }
  for (const auto& t : other.triangles) {
    std::array<std::uint32_t, 3> copy{};
    for (std::size_t n = 0; n < 3; ++n) copy[n] = t[n] == 5 ? 4 : t[n] + 6;
    pinched.triangles.push_back(copy);
  }
  EXPECT_FALSE(measure_quality(pinched).closed_manifold);
}

}  // namespace
}  // namespace beatlas::mesh
