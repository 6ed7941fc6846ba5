#include "pipeline/field/simple_topology.h"

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "pipeline/field/surface.h"
#include "pipeline/mesh/triangle_mesh.h"
#include "tests/unit/mesh/beating_shapes.h"

namespace beatlas::field {
namespace {

using closed_form::lattice;
using closed_form::sampled;

const Grid kGrid = lattice({-24, -24, -24}, {24, 24, 24}, 1.5);

// The Euler number of the surface itself, by an implementation that knows nothing of the body's.
int surface_euler_number(const Grid& grid, const std::vector<float>& samples, int& pieces) {
  FieldCycle field;
  field.distance_mm = {grid, {samples}};
  field.voxel_mm = grid.spacing_mm().x();
  TriangleSoup soup = extract_surface(field, 0);
  const mesh::TriangleMesh triangles{soup.points, soup.triangles};
  const mesh::Topology found = mesh::inspect(triangles.points.size(), triangles.triangles);
  EXPECT_TRUE(found.closed_manifold);
  pieces = mesh::largest_component(triangles).components;
  return found.euler_number;
}

void expect_ball(const Grid& grid, const std::vector<float>& samples) {
  EXPECT_TRUE(topology_of(grid, samples).is_ball());
  int pieces = 0;
  EXPECT_EQ(surface_euler_number(grid, samples, pieces), 2);
  EXPECT_EQ(pieces, 1);
}

std::vector<float> of(const std::function<double(const Vec3&)>& level) {
  return sampled(kGrid, level);
}

double ball(const Vec3& x, const Vec3& centre, double radius) {
  return (x - centre).norm() - radius;
}

TEST(SimpleTopology, CountsPiecesHollowsAndHandlesAsTheSurfaceHasThem) {
  // Random fields have all of them in plenty.
  std::mt19937 random(7);
  std::uniform_real_distribution<float> any(-1, 1);
  const Grid grid = lattice({0, 0, 0}, {12, 11, 10}, 1.0);
  for (const float bias : {-0.6F, -0.2F, 0.0F, 0.3F, 0.7F}) {
    std::vector<float> samples(grid.count(), 1.0F);
    for (int k = 1; k + 1 < grid.size[2]; ++k) {
      for (int j = 1; j + 1 < grid.size[1]; ++j) {
        for (int i = 1; i + 1 < grid.size[0]; ++i)
          samples[grid.offset(i, j, k)] = any(random) + bias;
      }
    }
    const BodyTopology body = topology_of(grid, samples);
    int surfaces = 0;
    const int euler = surface_euler_number(grid, samples, surfaces);
    EXPECT_EQ(surfaces, body.pieces + body.hollows);
    EXPECT_EQ(euler, 2 * (body.pieces + body.hollows - body.handles));
    EXPECT_GT(body.pieces + body.hollows + body.handles, 3);

    std::vector<float> mended = samples;
    EXPECT_EQ(make_ball(grid, mended).left_handles, 0);
    expect_ball(grid, mended);
  }
}

TEST(SimpleTopology, ABallIsLeftAsItIs) {
  const std::vector<float> samples = of([](const Vec3& x) { return ball(x, {1, 2, 0}, 15); });
  std::vector<float> same = samples;
  const Repair repair = make_ball(kGrid, same);
  EXPECT_TRUE(repair.before.is_ball());
  EXPECT_EQ(repair.changed, 0U);
  EXPECT_EQ(same, samples);
}

TEST(SimpleTopology, SmallPiecesGoAndHollowsAreFilled) {
  std::vector<float> samples = of([](const Vec3& x) {
    const double shell = std::max(ball(x, {-3, 0, 0}, 14), -ball(x, {-5, 0, 0}, 4));
    return std::min(shell, ball(x, {17, 0, 0}, 3));
  });
  const Repair repair = make_ball(kGrid, samples);
  EXPECT_EQ(repair.before.pieces, 2);
  EXPECT_EQ(repair.before.hollows, 1);
  EXPECT_EQ(repair.before.handles, 0);
  expect_ball(kGrid, samples);
  const Interpolant inside(kGrid, samples);
  EXPECT_LT(inside.value({-5, 0, 0}), 0);
  EXPECT_GT(inside.value({17, 0, 0}), 0);
}

TEST(SimpleTopology, ALargePieceIsJoinedWhereItIsNearestAndASpeckGoes) {
  // An outflow tract whose neck no slice shows, and a speck farther away than it is deep.
  std::vector<float> samples = of([](const Vec3& x) {
    const double parts = std::min(ball(x, {-8, 0, 0}, 11), ball(x, {13, 0, 0}, 8));
    return std::min(parts, ball(x, {-6, 19, 0}, 1.6));
  });
  const std::vector<float> before = samples;
  const Repair repair = make_ball(kGrid, samples);
  EXPECT_EQ(repair.before.pieces, 3);
  expect_ball(kGrid, samples);
  const Interpolant inside(kGrid, samples);
  EXPECT_LT(inside.value({13, 0, 0}), 0);
  EXPECT_LT(inside.value({4, 0, 0}), 0) << "the bridge, where both are nearest";
  EXPECT_GT(inside.value({-6, 19, 0}), 0);
  for (std::size_t n = 0; n < samples.size(); ++n) {
    // Beside the bridge and the speck nothing changes side.
    const Vec3 x =
        kGrid.mm_from_index * Vec3(static_cast<double>(n % 33), static_cast<double>(n / 33 % 33),
                                   static_cast<double>(n / 1089));
    if ((x - Vec3(4, 0, 0)).norm() < 5 || (x - Vec3(-6, 19, 0)).norm() < 5) continue;
    ASSERT_EQ(samples[n] < 0, before[n] < 0);
  }
}

TEST(SimpleTopology, AHoleInAThinPlaceIsFilled) {
  // A plate with a hole much smaller than the way around it.
  std::vector<float> samples = of([](const Vec3& x) {
    const double plate = std::max(std::abs(x.z()) - 2.5, std::hypot(x.x(), x.y()) - 18);
    return std::max(plate, 1.8 - std::hypot(x.x() - 3, x.y()));
  });
  const Repair repair = make_ball(kGrid, samples);
  EXPECT_EQ(repair.before.handles, 1);
  EXPECT_LT(repair.changed, 30U);
  expect_ball(kGrid, samples);
  EXPECT_LT(Interpolant(kGrid, samples).value({3, 0, 0}), 0);
}

TEST(SimpleTopology, AThinStrandIsCut) {
  // Two balls in contact that a thread joins a second time.
  std::vector<float> samples = of([](const Vec3& x) {
    const double balls = std::min(ball(x, {-8, 0, 0}, 10), ball(x, {8, 0, 0}, 10));
    const double thread = std::hypot(std::hypot(x.x(), x.y()) - 14, x.z()) - 1.4;
    return std::min(balls, std::max(thread, -x.y()));
  });
  const Repair repair = make_ball(kGrid, samples);
  EXPECT_EQ(repair.before.handles, 1);
  EXPECT_LT(repair.changed, 12U);
  expect_ball(kGrid, samples);
  EXPECT_LT(Interpolant(kGrid, samples).value({0, 0, 0}), 0);  // the contact stays
}

TEST(SimpleTopology, EachHandleIsClosedTheCheaperWay) {
  std::vector<float> samples = of([](const Vec3& x) {
    const double plate = std::max(std::abs(x.z()) - 2.5, std::hypot(x.x(), x.y()) - 18);
    const double holed = std::max(plate, 1.8 - std::hypot(x.x() - 3, x.y()));
    const double arch = std::hypot(std::hypot(x.x() + 6, x.z()) - 8, x.y() + 8) - 1.3;
    return std::min(holed, std::max(arch, -x.z()));
  });
  EXPECT_EQ(topology_of(kGrid, samples).handles, 2);
  const Repair repair = make_ball(kGrid, samples);
  EXPECT_EQ(repair.left_handles, 0);
  EXPECT_LT(repair.changed, 40U);
  expect_ball(kGrid, samples);
  EXPECT_LT(Interpolant(kGrid, samples).value({3, 0, 0}), 0);
}

TEST(SimpleTopology, ClampedDistancesAndThinSheetsAreNoTrouble) {
  std::vector<float> samples = of([](const Vec3& x) {
    const double cup = std::max({ball(x, {0, 0, 0}, 18), -ball(x, {0, 0, 2}, 14), x.z() - 6});
    return std::clamp(cup, -1.0, 1.5);
  });
  ASSERT_TRUE(topology_of(kGrid, samples).is_ball());
  std::vector<float> punched = samples;
  const Index3 at{16 + 11, 16, 16 - 3};
  int punches = 0;
  for (int i = 0; i < kGrid.size[0]; ++i) {
    float& sample = punched[kGrid.offset(i, at[1], at[2])];
    if (i > 16 && sample < 0) {
      sample = 0.5F;
      ++punches;
    }
  }
  ASSERT_GT(punches, 0);
  ASSERT_EQ(topology_of(kGrid, punched).handles, 1);
  const Repair repair = make_ball(kGrid, punched);
  EXPECT_LE(repair.changed, 4U);
  expect_ball(kGrid, punched);
}

}  // namespace
}  // namespace beatlas::field
