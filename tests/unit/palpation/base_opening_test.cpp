#include "runtime/palpation/base_opening.h"

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "tests/unit/palpation/sample_wall.h"

namespace beatlas::palpation {
namespace {

// The sample's wall is missing where z is above 0.9 of the radius: a cap of 0.436 radii.
TEST(BaseOpening, IsHalfAsWideAsWhatHasNoWallAndLiesOnIt) {
  const test::SampleWall sample(4, 6);
  const std::vector<haptics::Opening> openings = base_opening(*sample.surface, *sample.map);
  ASSERT_EQ(openings.size(), 4U);
  for (std::size_t p = 0; p < openings.size(); ++p) {
    const double radius_mm = p == 0 ? 25 : p == 2 ? 20 : 22.5;
    const haptics::Opening& found = openings[p];
    // Triangles at the rim have a wall at one corner and are left out.
    EXPECT_NEAR(found.radius_mm, 0.5 * std::sqrt(1 - 0.81) * radius_mm, 0.03 * radius_mm);
    EXPECT_NEAR(found.normal.z(), 1, 1e-3);
    EXPECT_NEAR(found.centre_mm.z(), 0.95 * radius_mm, 0.02 * radius_mm);
    EXPECT_LT(found.centre_mm.head<2>().norm(), 0.01 * radius_mm);
  }
}

TEST(BaseOpening, OfAClosedOrOfAnotherSurfaceIsRefused) {
  const test::SampleWall sample;
  atlas::SurfaceMapPayload closed = *sample.map;
  for (auto& phase : closed.thickness_mm) {
    for (float& mm : phase) mm = 8;
  }
  EXPECT_THROW((void)base_opening(*sample.surface, closed), Error);
  atlas::SurfaceMapPayload fewer = *sample.map;
  fewer.thickness_mm.pop_back();
  EXPECT_THROW((void)base_opening(*sample.surface, fewer), Error);
}

}  // namespace
}  // namespace beatlas::palpation
