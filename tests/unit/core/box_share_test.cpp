/// The share of a box beside a plane.
#include "pipeline/core/box_share.h"

#include <cmath>

#include <gtest/gtest.h>

namespace beatlas {
namespace {

TEST(ShareBelow, IsThePartOfTheBoxOnThePlanesInnerSide) {
  const Vec3 half(0.5, 0.7, 1.5);
  constexpr int kPoints = 60;
  for (const Vec3& along : {Vec3(0, 0, 1), Vec3(-1, 0, 0), Vec3(1, 1, 0), Vec3(0.3, -0.2, 0.9),
                            Vec3(-1, 2, -3), Vec3(1e-9, 1, 1)}) {
    const Vec3 normal = along.normalized();
    for (const double offset : {-1.0, -0.4, 0.0, 0.3, 0.9}) {
      int below = 0;
      for (int c = 0; c < kPoints; ++c) {
        for (int b = 0; b < kPoints; ++b) {
          for (int a = 0; a < kPoints; ++a) {
            const Vec3 x =
                half.cwiseProduct((2 * Vec3(a + 0.5, b + 0.5, c + 0.5) / kPoints) - Vec3::Ones());
            below += normal.dot(x) < offset ? 1 : 0;
          }
        }
      }
      EXPECT_NEAR(share_below(normal, half, offset), below / std::pow(kPoints, 3), 0.012)
          << along.transpose() << ", " << offset;
    }
  }
  EXPECT_EQ(share_below(Vec3::UnitZ(), half, -2), 0);
  EXPECT_EQ(share_below(Vec3::UnitZ(), half, 2), 1);
}

}  // namespace
}  // namespace beatlas
