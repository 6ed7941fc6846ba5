/// Ventricles as real ones are: hardly longer than wide with their wall, cut by thick slices that
/// end where they end, with a gap in the wall toward the outflow tract.
#include "pipeline/core/lv_direction.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace beatlas {
namespace {

struct Lv {
  Grid grid;
  std::vector<float> blood;
  std::vector<float> muscle;
};

struct Shape {
  double radius_mm = 27;
  double length_mm = 70;  ///< of the cavity, from its apex to the flat base
  double wall_mm = 9;
  double leans_deg = 0;      ///< of the axis, off the slices' normal
  double first_mm = -70;     ///< slices from here
  double last_mm = 70;       ///< to here, of the middle
  double gap_from_mm = 1e9;  ///< above it the wall is open over 120 degrees
  Vec3 spacing{1.4, 1.4, 10};
};

/// Half an ellipsoid within another; what lies in which is asked at 3 x 3 x 3 points a voxel.
Lv lv_of(const Shape& shape, const Vec3& axis) {
  Lv out;
  out.grid.size = {80, 80, static_cast<int>(140 / shape.spacing[2])};
  const Vec3 half(0.5 * (out.grid.size[0] - 1), 0.5 * (out.grid.size[1] - 1),
                  0.5 * (out.grid.size[2] - 1));
  out.grid.mm_from_index.linear() = shape.spacing.asDiagonal();
  out.grid.mm_from_index.translation() = -shape.spacing.cwiseProduct(half);
  const double base_mm = 0.5 * shape.length_mm;
  const Vec3 aside = (Vec3::UnitX() - axis.x() * axis).normalized();
  for (int k = 0; k < out.grid.size[2]; ++k) {
    const double slice_mm = out.grid.mm(0, 0, k).z();
    for (int j = 0; j < out.grid.size[1]; ++j) {
      for (int i = 0; i < out.grid.size[0]; ++i) {
        double blood = 0;
        double muscle = 0;
        for (int n = 0; n < 27 && slice_mm >= shape.first_mm && slice_mm <= shape.last_mm; ++n) {
          const Vec3 within(n % 3 / 3.0 - 1 / 3.0, n / 3 % 3 / 3.0 - 1 / 3.0,
                            n / 9 / 3.0 - 1 / 3.0);
          const Vec3 p = out.grid.mm(i, j, k) + shape.spacing.cwiseProduct(within);
          const double along = p.dot(axis) - base_mm;
          if (along > 0) continue;
          const Vec3 across = p - p.dot(axis) * axis;
          const auto inside = [&](double more) {
            return across.squaredNorm() / std::pow(shape.radius_mm + more, 2) +
                       along * along / std::pow(shape.length_mm + more, 2) <
                   1;
          };
          const bool open =
              p.dot(axis) > shape.gap_from_mm && across.dot(aside) > 0.5 * across.norm();
          if (inside(0)) {
            blood += 1.0 / 27;
          } else if (inside(shape.wall_mm) && !open) {
            muscle += 1.0 / 27;
          }
        }
        out.blood.push_back(static_cast<float>(blood));
        out.muscle.push_back(static_cast<float>(muscle));
      }
    }
  }
  return out;
}

double degrees_off(const Shape& shape) {
  const double lean = shape.leans_deg * std::numbers::pi / 180;
  const Vec3 axis(std::sin(lean) * 0.6, std::sin(lean) * 0.8, std::cos(lean));
  const Lv lv = lv_of(shape, axis);
  const std::optional<Vec3> found = lv_direction(lv.grid, lv.blood, lv.muscle);
  if (!found) return 180;
  return std::acos(std::clamp(found->dot(axis), -1.0, 1.0)) * 180 / std::numbers::pi;
}

TEST(LvDirection, IsTheAxisWhereThickSlicesLieAcross) {
  EXPECT_LT(degrees_off({}), 1);
  EXPECT_LT(degrees_off({.leans_deg = 10}), 3);
}

TEST(LvDirection, OfAWideVentricleIsNotItsWidestWay) {
  EXPECT_LT(degrees_off({.radius_mm = 36, .length_mm = 60}), 1);
  EXPECT_LT(degrees_off({.radius_mm = 36, .length_mm = 60, .leans_deg = 10}), 5);
}

TEST(LvDirection, IsSeenInFourSlicesOfItsMiddle) {
  EXPECT_LT(degrees_off({.first_mm = -16, .last_mm = 24}), 1);
  EXPECT_LT(degrees_off({.leans_deg = 10, .first_mm = -16, .last_mm = 24}), 5);
}

TEST(LvDirection, StandsAWallThatIsOpenTowardTheOutflowTract) {
  EXPECT_LT(degrees_off({.gap_from_mm = 12}), 5);
}

TEST(LvDirection, FollowsAVentricleThatLiesAlongTheSlices) {
  EXPECT_LT(degrees_off({.leans_deg = 60, .spacing = Vec3(1.4, 1.4, 4)}), 2);
  EXPECT_LT(degrees_off({.leans_deg = 50}), 8);  // slices of 10 mm
}

TEST(LvDirection, IsNoneWithoutAWall) {
  Lv lv = lv_of({}, Vec3::UnitZ());
  lv.muscle.assign(lv.muscle.size(), 0);
  EXPECT_FALSE(lv_direction(lv.grid, lv.blood, lv.muscle));
}

}  // namespace
}  // namespace beatlas
