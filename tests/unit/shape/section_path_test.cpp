#include "pipeline/shape/section_path.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/unit/shape/made_shapes.h"

namespace beatlas::shape {
namespace {

/// Discs of `radius` pixels, one a slice, about middle + slice * step.
std::vector<float> leaning_discs(const Grid& grid, double radius, const Eigen::Vector2d& middle,
                                 const Eigen::Vector2d& step) {
  std::vector<float> out;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const double r = (Eigen::Vector2d(i, j) - middle - k * step).norm();
        out.push_back(static_cast<float>(std::clamp(0.5 - (r - radius), 0.0, 1.0)));
      }
    }
  }
  return out;
}

const Grid kGrid = made::straight_grid({60, 70, 4}, {1.5, 1.5, 10});

TEST(SectionPath, OfALeaningCylinderIsItsLean) {
  const Eigen::Vector2d step(-4, 5);
  const SectionPath path = section_path(
      kGrid, {leaning_discs(kGrid, 8, {40, 20}, step), leaning_discs(kGrid, 7, {38, 22}, step)});
  ASSERT_EQ(path.size(), 4U);
  for (std::size_t k = 1; k < path.size(); ++k) {
    EXPECT_LE((path[k] - path[k - 1] - step).norm(), 1.5) << k;
  }
}

TEST(SectionPath, StaysWhereOneSectionLiesWithinTheOther) {
  std::vector<float> cone;
  for (int k = 0; k < 4; ++k) {
    const Grid one = made::straight_grid({60, 70, 1}, {1.5, 1.5, 10});
    const std::vector<float> disc = leaning_discs(one, 20 - 4 * k, {30.0 + k, 35}, {0, 0});
    cone.insert(cone.end(), disc.begin(), disc.end());
  }
  for (const Eigen::Vector2d& at : section_path(kGrid, {cone})) EXPECT_EQ(at.norm(), 0);
}

TEST(SectionPath, HasNoStepToASliceWithoutASectionNorOneBeyondTheGap) {
  std::vector<float> gap = leaning_discs(kGrid, 8, {30, 20}, {0, 4});
  std::fill_n(gap.begin() + static_cast<std::ptrdiff_t>(kGrid.offset(0, 0, 2)), kGrid.slice_count(),
              0.0F);
  const SectionPath path = section_path(kGrid, {gap});
  EXPECT_EQ(path[2], path[1]);
  EXPECT_EQ(path[3], path[2]);
  const std::vector<float> far = leaning_discs(kGrid, 8, {15, 20}, {12, 0});
  const SectionPath steep = section_path(kGrid, {far});
  for (std::size_t k = 1; k < 4; ++k) EXPECT_LE(1.5 * (steep[k] - steep[k - 1]).norm(), 10);
}

}  // namespace
}  // namespace beatlas::shape
