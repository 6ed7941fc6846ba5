/// What a servo's tick asks of a shell allocates nothing.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/field/shell_query.h"
#include "tests/realtime/allocations.h"
#include "tests/unit/runtime_field/test_fields.h"

namespace beatlas {
namespace {

using testing::allocations;
using testing::counting;

TEST(ShellQuery, AllocatesNothingFromItsFirstTickOn) {
  const auto query = std::make_shared<const field::FieldQuery>(
      testing::dense_payload({.origin_mm = Vec3::Constant(-24)},
                             [](const Vec3& x, double t) { return x.norm() - 15 - std::sin(t); }),
      0.75);
  for (const double radius_mm : {3.0, 60.0}) {  // a box, and one that does not fit
    std::vector<Vec3> points;
    for (int n = 0; n < 1000; ++n) {
      points.emplace_back(Vec3(12, 0, 0) +
                          radius_mm * Vec3(std::sin(n), std::cos(n), std::sin(1.7 * n)));
    }
    std::vector<field::FieldSample> found(points.size());
    field::ShellQuery shells(query);
    allocations = 0;
    counting = true;
    for (int tick = 0; tick < 50; ++tick) shells.sample(points, 0.001 * tick, found);
    counting = false;
    EXPECT_EQ(allocations, 0);
  }
  // The counter counts.
  counting = true;
  const std::vector<int> some(10);
  counting = false;
  EXPECT_GE(allocations, 1);
}

}  // namespace
}  // namespace beatlas
