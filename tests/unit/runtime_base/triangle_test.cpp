/// The nearest point of a triangle, over its face, beside each side and beyond each corner.
#include "runtime/base/triangle.h"

#include <gtest/gtest.h>

namespace beatlas {
namespace {

const Vec3 kA(0, 0, 0);
const Vec3 kB(4, 0, 0);
const Vec3 kC(0, 3, 0);

Vec3 nearest(const Vec3& p) {
  const Vec3 weights = nearest_of_triangle(p, kA, kB, kC);
  EXPECT_NEAR(weights.sum(), 1, 1e-12);
  EXPECT_GE(weights.minCoeff(), 0);
  return weights[0] * kA + weights[1] * kB + weights[2] * kC;
}

TEST(NearestOfTriangle, IsOnItsFaceItsSidesOrItsCorners) {
  EXPECT_LT((nearest({1, 1, 5}) - Vec3(1, 1, 0)).norm(), 1e-12);
  EXPECT_LT((nearest({2, -1, -2}) - Vec3(2, 0, 0)).norm(), 1e-12);
  EXPECT_LT((nearest({-3, 1, 1}) - Vec3(0, 1, 0)).norm(), 1e-12);
  EXPECT_LT((nearest({2 + 3, 1.5 + 4, 1}) - Vec3(2, 1.5, 0)).norm(), 1e-12);
  EXPECT_LT((nearest({-1, -2, 3}) - kA).norm(), 1e-12);
  EXPECT_LT((nearest({9, -1, 0}) - kB).norm(), 1e-12);
  EXPECT_LT((nearest({-1, 8, 0}) - kC).norm(), 1e-12);
}

TEST(NearestOfTriangle, OfNoAreaIsAPointOfIt) {
  const Vec3 weights = nearest_of_triangle({1, 1, 1}, kA, kA, kA);
  EXPECT_NEAR(weights.sum(), 1, 1e-12);
}

}  // namespace
}  // namespace beatlas
