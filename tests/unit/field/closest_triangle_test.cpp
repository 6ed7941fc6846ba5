#include "pipeline/field/closest_triangle.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace beatlas::field {
namespace {

// Independent of the Voronoi regions: the foot on the plane if it is inside, else the nearest side.
double slow_distance2(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const auto to_segment = [&](const Vec3& u, const Vec3& v) {
    const double length2 = (v - u).squaredNorm();
    const double t = length2 > 0 ? std::clamp((p - u).dot(v - u) / length2, 0.0, 1.0) : 0.0;
    return (p - u - t * (v - u)).squaredNorm();
  };
  double best = std::min({to_segment(a, b), to_segment(b, c), to_segment(c, a)});
  const Vec3 n = (b - a).cross(c - a);
  if (n.squaredNorm() > 0) {
    const Vec3 q = p - n.dot(p - a) / n.squaredNorm() * n;
    if (n.dot((b - a).cross(q - a)) >= 0 && n.dot((c - b).cross(q - b)) >= 0 &&
        n.dot((a - c).cross(q - c)) >= 0) {
      best = std::min(best, (p - q).squaredNorm());
    }
  }
  return best;
}

TEST(ClosestTriangle, AgreesWithTryingAllTriangles) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> in_box(-10, 10);
  const auto point = [&] { return Vec3(in_box(random), in_box(random), in_box(random)); };
  TriangleSoup soup;
  for (std::uint32_t n = 0; n < 300; ++n) {
    const Vec3 a = point();
    const Vec3 b = a + 0.2 * point();
    // Some triangles are segments and some are points.
    const Vec3 c =
        n % 7 == 0 ? b : (n % 11 == 0 ? Vec3(0.3 * a + 0.7 * b) : Vec3(a + 0.2 * point()));
    soup.points.insert(soup.points.end(), {a, n % 77 == 0 ? a : b, n % 77 == 0 ? a : c});
    soup.triangles.push_back({3 * n, 3 * n + 1, 3 * n + 2});
  }
  const ClosestTriangle tree(soup);
  for (int n = 0; n < 2000; ++n) {
    const Vec3 p = 1.3 * point();
    double want = std::numeric_limits<double>::infinity();
    for (const auto& t : soup.triangles) {
      want = std::min(want,
                      slow_distance2(p, soup.points[t[0]], soup.points[t[1]], soup.points[t[2]]));
    }
    const ClosestTriangle::Hit hit = tree.nearest(p, {});
    ASSERT_NEAR(std::sqrt(hit.distance2_mm2), std::sqrt(want), 1e-5);
    ASSERT_EQ(tree.nearest_of(hit.four, p, {}).distance2_mm2, hit.distance2_mm2);
  }
  // Around a place there is the same to find as in the whole.
  for (int n = 0; n < 50; ++n) {
    const Vec3 middle = point();
    const double reach = std::sqrt(tree.nearest(middle, {}).distance2_mm2) + 2.01;
    ClosestTriangle::Vicinity wide;
    ClosestTriangle::Vicinity about;
    tree.gather(middle, 2 * reach, reach, nullptr, wide);
    tree.gather(middle, reach, 0.3 * reach, &wide, about);
    for (int m = 0; m < 20; ++m) {
      const Vec3 p = middle + point().normalized();
      ASSERT_EQ(tree.nearest(p, {}, about).distance2_mm2, tree.nearest(p, {}).distance2_mm2);
    }
  }
}

TEST(ClosestTriangle, GivesTheBoundBackWhenNothingIsNearer) {
  TriangleSoup soup;
  soup.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  soup.triangles = {{0, 1, 2}};
  const ClosestTriangle tree(soup);
  EXPECT_EQ(tree.nearest({0, 0, 5}, {4.0F, 99}).four, 99U);
  EXPECT_EQ(tree.nearest({0, 0, 5}, {25.1F, 99}).four, 0U);
  EXPECT_TRUE(std::isinf(ClosestTriangle(TriangleSoup{}).nearest({0, 0, 0}, {}).distance2_mm2));
}

}  // namespace
}  // namespace beatlas::field
