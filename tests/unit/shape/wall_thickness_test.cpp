#include "pipeline/shape/wall_thickness.h"

#include <gtest/gtest.h>

#include "pipeline/core/grid.h"

namespace beatlas::shape {
namespace {

/// A tube of blood of 15 mm radius in a wall of 7 mm, in all slices but the first, which holds
/// blood alone.
CoverageCycle tube() {
  CoverageCycle out;
  out.grid.size = {64, 64, 4};
  out.grid.mm_from_index = Eigen::Scaling(1.5, 1.5, 8.0);
  const Vec3 middle = out.grid.mm(31.5, 31.5, 0);
  std::vector<float> blood(out.grid.count(), 0);
  std::vector<float> muscle = blood;
  for_each_voxel(out.grid, [&](int i, int j, int k, std::size_t v) {
    const double radius = (out.grid.mm(i, j, 0) - middle).norm();
    if (radius < 15) blood[v] = 1;
    if (k > 0 && radius >= 15 && radius < 22) muscle[v] = 1;
  });
  out.phases[Structure::LvBlood] = {blood, blood};
  out.phases[Structure::LvMyocardium] = {muscle, muscle};
  return out;
}

TEST(WallThickness, IsTheWidthOfTheRing) {
  const std::optional<double> wall_mm = wall_thickness_mm(tube());
  ASSERT_TRUE(wall_mm.has_value());
  EXPECT_NEAR(*wall_mm, 7, 0.2);
}

TEST(WallThickness, IsUnknownWithoutMuscle) {
  CoverageCycle blood_alone = tube();
  blood_alone.phases.erase(Structure::LvMyocardium);
  EXPECT_FALSE(wall_thickness_mm(blood_alone).has_value());
}

}  // namespace
}  // namespace beatlas::shape
