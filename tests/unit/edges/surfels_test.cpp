/// Pieces of a surface, against an ellipsoid in closed form.
#include "pipeline/edges/surfels.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/made_images.h"

namespace beatlas::edges::surfels_tests {
namespace {

TEST(Surfels, LieOnABallLookOutwardAndBendAsItDoes) {
  constexpr double kRadiusMm = 25;
  made::BeatingEllipsoid ball;
  ball.largest_mm = Vec3::Constant(kRadiusMm);
  ball.squeeze = 0;
  ball.centre_lps = Vec3(32.3, 33.1, 36.4);
  const Grid grid = made::straight_grid({66, 66, 25}, {1, 1, 3});
  std::vector<float> coverage(grid.count());
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        coverage[grid.offset(i, j, k)] = static_cast<float>(ball.share(grid, i, j, k, 0, 2));
      }
    }
  }
  const std::vector<Surfel> surfels = surfels_of(grid, coverage, 3);
  // One for some 9 mm^2, and some more where the surface passes a corner of a cell.
  const double area = 4 * std::numbers::pi * kRadiusMm * kRadiusMm;
  EXPECT_GT(static_cast<double>(surfels.size()), area / 9);
  EXPECT_LT(static_cast<double>(surfels.size()), 2 * area / 9);
  double off = 0;
  double angle = 0;
  double bend = 0;
  for (const Surfel& surfel : surfels) {
    const Vec3 from = surfel.at - ball.centre_lps;
    off += from.norm() - kRadiusMm;
    EXPECT_NEAR(from.norm(), kRadiusMm, 0.6);
    angle += std::acos(std::min(1.0, from.normalized().dot(surfel.normal)));
    bend += 0.5 * (surfel.bend[0] + surfel.bend[2]);
    EXPECT_NEAR(surfel.along.dot(surfel.across), 0, 1e-9);
    EXPECT_NEAR(surfel.along.cross(surfel.across).dot(surfel.normal), 1, 1e-9);
  }
  const auto count = static_cast<double>(surfels.size());
  EXPECT_LT(angle / count * 180 / std::numbers::pi, 1.5);
  // A Gaussian of s moves a ball's level inward by s^2 / R, 0.16 mm.
  EXPECT_NEAR(off / count, -0.16, 0.08);
  EXPECT_NEAR(bend / count, -0.5 / kRadiusMm, 0.15 * 0.5 / kRadiusMm);
}

TEST(Surfels, NothingHasNone) {
  const Grid grid = made::straight_grid({8, 8, 4}, {1, 1, 3});
  EXPECT_TRUE(surfels_of(grid, std::vector<float>(grid.count(), 0), 3).empty());
  EXPECT_TRUE(surfels_of(grid, std::vector<float>(grid.count(), 1), 3).empty());
}

TEST(PlacesNearby, FindsAllWithinReachAndNoOther) {
  std::vector<Vec3> places;
  for (int n = 0; n < 400; ++n) {
    places.emplace_back(std::fmod(n * 7.31, 20), std::fmod(n * 3.77, 15), std::fmod(n * 1.93, 9));
  }
  const PlacesNearby nearby(places, 4);
  for (const Vec3& from : {Vec3(3, 3, 3), Vec3(-2, 14, 5), Vec3(100, 0, 0)}) {
    std::vector<std::size_t> found;
    nearby.visit(from, [&](std::size_t n, const Vec3& off) {
      EXPECT_EQ(off, Vec3(places[n] - from));
      found.push_back(n);
    });
    std::sort(found.begin(), found.end());
    std::vector<std::size_t> expected;
    for (std::size_t n = 0; n < places.size(); ++n) {
      if ((places[n] - from).norm() <= 4) expected.push_back(n);
    }
    EXPECT_EQ(found, expected);
  }
  PlacesNearby({}, 4).visit(Vec3::Zero(), [](std::size_t, const Vec3&) { FAIL(); });
}

}  // namespace
}  // namespace beatlas::edges::surfels_tests
