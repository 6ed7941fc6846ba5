#include <random>

#include <gtest/gtest.h>

#include "pipeline/mesh/mesh.h"
#include "pipeline/mesh/triangle_mesh.h"
#include "tests/unit/unit_sphere.h"

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

/// Whether a segment passes through a triangle's inside.
bool pierces(const Vec3& from, const Vec3& to, const Vec3& a, const Vec3& b, const Vec3& c) {
  const auto volume = [](const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s) {
    return (q - p).cross(r - p).dot(s - p);
  };
  if ((volume(a, b, c, from) > 0) == (volume(a, b, c, to) > 0)) return false;
  const bool ab = volume(from, to, a, b) > 0;
  return ab == (volume(from, to, b, c) > 0) && ab == (volume(from, to, c, a) > 0);
}

TEST(SelfIntersections, AreThoseThatTryingAllPairsFinds) {
  const test::UnitSphere sphere = test::unit_sphere(3);
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 0.15);
  std::vector<Vec3> points = sphere.points;
  for (Vec3& x : points) x += Vec3(noise(random), noise(random), noise(random));
  std::vector<std::pair<std::uint32_t, std::uint32_t>> want;
  std::vector<bool> among(sphere.triangles.size(), false);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> want_among;
  for (std::size_t n = 0; n < among.size(); n += 5) among[n] = true;
  for (std::uint32_t one = 0; one < sphere.triangles.size(); ++one) {
    for (std::uint32_t other = one + 1; other < sphere.triangles.size(); ++other) {
      const auto& s = sphere.triangles[one];
      const auto& t = sphere.triangles[other];
      const auto has = [](const Triangle& of, std::uint32_t v) {
        return of[0] == v || of[1] == v || of[2] == v;
      };
      const auto crosses = [&](const Triangle& u, const Triangle& v) {
        for (std::size_t n = 0; n < 3; ++n) {
          const std::uint32_t a = u[n];
          const std::uint32_t b = u[(n + 1) % 3];
          if (has(v, a) || has(v, b)) continue;
          if (pierces(points[a], points[b], points[v[0]], points[v[1]], points[v[2]])) return true;
        }
        return false;
      };
      // Two that share an edge meet nowhere else.
      const int shared = (has(t, s[0]) ? 1 : 0) + (has(t, s[1]) ? 1 : 0) + (has(t, s[2]) ? 1 : 0);
      if (shared > 1 || !(crosses(s, t) || crosses(t, s))) continue;
      want.emplace_back(one, other);
      if (among[one] || among[other]) want_among.emplace_back(one, other);
    }
  }
  ASSERT_GT(want.size(), 100U);
  EXPECT_EQ(self_intersections(points, sphere.triangles), want);
  EXPECT_EQ(self_intersections(points, sphere.triangles, among), want_among);
}

TEST(SelfIntersections, SeeTwoThatLieFlatOnEachOther) {
  // A corner folded over its neighbour, in one plane.
  const std::vector<Vec3> points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.7, 0}};
  const std::vector<Triangle> folded{{0, 1, 2}, {1, 0, 3}};
  EXPECT_EQ(self_intersections(points, folded).size(), 1U);
  const std::vector<Vec3> open{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, -0.7, 0}};
  EXPECT_TRUE(self_intersections(open, folded).empty());
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
