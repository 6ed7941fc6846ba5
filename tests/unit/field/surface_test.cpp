#include "pipeline/field/surface.h"

#include <map>
#include <random>

#include <gtest/gtest.h>

#include "tests/unit/field/closed_form.h"

namespace beatlas::field {
namespace {

// Every directed edge once, and its opposite once: closed, 2-manifold at edges, oriented alike.
bool is_closed(const TriangleSoup& surface) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& t : surface.triangles) {
    for (std::size_t n = 0; n < 3; ++n) ++edges[{t[n], t[(n + 1) % 3]}];
  }
  for (const auto& [edge, count] : edges) {
    const auto opposite = edges.find({edge.second, edge.first});
    if (count != 1 || opposite == edges.end()) return false;
  }
  return true;
}

FieldCycle field_of(const Grid& grid, std::vector<float> samples) {
  FieldCycle field;
  field.voxel_mm = grid.spacing_mm().x();
  field.distance_mm.grid = grid;
  field.distance_mm.phases.push_back(std::move(samples));
  return field;
}

TEST(ExtractSurface, OfABallIsAClosedSphereSeenFromOutside) {
  const Grid grid = closed_form::lattice({-16, -16, -16}, {16, 16, 16}, 1.5);
  const TriangleSoup surface = extract_surface(
      field_of(grid, closed_form::sampled(grid, [](const Vec3& x) { return x.norm() - 11.0; })), 0);
  EXPECT_TRUE(is_closed(surface));
  EXPECT_EQ(surface.points.size() + surface.triangles.size() - 3 * surface.triangles.size() / 2,
            2U);
  EXPECT_NEAR(enclosed_ml(surface), 4.0 / 3.0 * std::numbers::pi * 1.331, 0.06);  // chords: 1 %
  for (const Vec3& p : surface.points) ASSERT_NEAR(p.norm(), 11.0, 0.1);
}

TEST(ExtractSurface, OfPureNoiseIsStillAClosedManifold) {
  Grid grid;
  grid.size = {14, 13, 12};
  std::vector<float> samples(grid.count(), 1.0F);
  std::mt19937 random(3);
  std::uniform_int_distribution<int> pick(-2, 2);  // zeros included
  for (int k = 1; k + 1 < grid.size[2]; ++k) {
    for (int j = 1; j + 1 < grid.size[1]; ++j) {
      for (int i = 1; i + 1 < grid.size[0]; ++i) {
        samples[grid.offset(i, j, k)] = static_cast<float>(pick(random));
      }
    }
  }
  const TriangleSoup surface = extract_surface(field_of(grid, samples), 0);
  EXPECT_GT(surface.triangles.size(), 1000U);
  EXPECT_TRUE(is_closed(surface));
  EXPECT_GT(enclosed_ml(surface), 0);
}

TEST(LevelSurface, IsEmptyWithoutAChangeOfSign) {
  Grid grid;
  grid.size = {5, 5, 5};
  EXPECT_TRUE(level_surface(grid, std::vector<float>(125, 1.0F)).triangles.empty());
  EXPECT_TRUE(level_surface(grid, std::vector<float>(125, -1.0F)).triangles.empty());
}

TEST(LevelSurface, ReachesSmallBallsAndPointsOutward) {
  const closed_form::Ellipsoid ball{{0, 0, 0}, {4, 4, 4}};
  const Grid grid = closed_form::lattice({-9, -9, -9}, {9, 9, 9}, 1.0);
  const TriangleSoup surface = level_surface(
      grid, closed_form::sampled(grid, [&](const Vec3& x) { return ball.distance_mm(x); }));
  EXPECT_TRUE(is_closed(surface));
  // Facets sag by 0.017 mm on average at a radius of 4 mm: 3 * 0.017 / 4 of the volume.
  EXPECT_NEAR(enclosed_ml(surface) / ball.volume_ml(), 1.0, 0.02);
}

}  // namespace
}  // namespace beatlas::field
