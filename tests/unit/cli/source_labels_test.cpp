#include "pipeline/cli/source_labels.h"

#include <cmath>

#include <gtest/gtest.h>

#include "pipeline/pack/pack.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
namespace {

constexpr int kPhases = 4;
const Vec3 kCentre(60, 60, 60);

/// A ball of the workspace whose radius changes over the cycle.
double radius_mm(double largest_mm, int phase) { return largest_mm - (phase % 2 == 0 ? 0 : 2); }

std::shared_ptr<const atlas::FieldPayload> ball(Structure structure, double largest_mm) {
  FieldCycle cycle;
  cycle.structure = structure;
  cycle.voxel_mm = 1.5;
  cycle.inner_mm = 10;
  cycle.outer_mm = 6;
  Grid grid{{64, 64, 64}, Affine::Identity()};
  grid.mm_from_index.linear() = 1.5 * Eigen::Matrix3d::Identity();
  grid.mm_from_index.translation() = kCentre - Vec3::Constant(1.5 * 31.5);
  cycle.distance_mm.grid = grid;
  for (int p = 0; p < kPhases; ++p) {
    std::vector<float> distance(grid.count());
    for (int k = 0; k < 64; ++k) {
      for (int j = 0; j < 64; ++j) {
        for (int i = 0; i < 64; ++i) {
          const double d = (grid.mm(i, j, k) - kCentre).norm() - radius_mm(largest_mm, p);
          distance[grid.offset(i, j, k)] = static_cast<float>(std::clamp(d, -10.0, 6.0));
        }
      }
    }
    cycle.distance_mm.phases.push_back(std::move(distance));
    cycle.volume_ml.push_back(1);
  }
  return std::make_shared<atlas::FieldPayload>(pack::encode_field(cycle, {}));
}

TEST(SourceLabels, are_the_signs_of_the_fields_on_an_oblique_grid) {
  const double heart_mm = 30;
  const double cavity_mm = 18;
  const Affine workspace_from_lps =
      Eigen::Translation3d(60, 60, 60) * Eigen::AngleAxisd(0.7, Vec3(1, -2, 1).normalized());
  Grid grid{{50, 40, 12}, Affine::Identity()};
  grid.mm_from_index.linear() =
      Eigen::AngleAxisd(0.3, Vec3::UnitX()).toRotationMatrix() * Vec3(1.7, 1.9, 8).asDiagonal();
  grid.mm_from_index.translation() = -(grid.mm_from_index.linear() * Vec3(24, 20, 6));
  StageContext context;
  const LabelCycle labels =
      labels_from_fields({ball(Structure::Heart, heart_mm), ball(Structure::LvBlood, cavity_mm)},
                         grid, workspace_from_lps, 0.8, context);
  ASSERT_EQ(labels.phase_count(), kPhases);
  std::size_t inside = 0;
  for (int p = 0; p < kPhases; ++p) {
    for (int k = 0; k < 12; ++k) {
      for (int j = 0; j < 40; ++j) {
        for (int i = 0; i < 50; ++i) {
          const double r = grid.mm(i, j, k).norm();  // the ball's centre is the LPS origin
          const double heart = r - radius_mm(heart_mm, p);
          const double cavity = r - radius_mm(cavity_mm, p);
          // The field is coded to 0.01 mm and exact for a ball to about 0.02 mm.
          if (std::abs(heart) < 0.1 || std::abs(cavity) < 0.1) continue;
          const int expected = cavity < 0  ? kLabelLvBlood
                               : heart < 0 ? kLabelRestOfHeart
                                           : kLabelBackground;
          ASSERT_EQ(labels.phases[static_cast<std::size_t>(p)][grid.offset(i, j, k)], expected)
              << i << " " << j << " " << k << " phase " << p;
          if (expected != 0) ++inside;
        }
      }
    }
  }
  EXPECT_GT(inside, 4000U);
}

TEST(SourceLabels, need_a_field) {
  StageContext context;
  EXPECT_THROW(
      (void)labels_from_fields({}, {{2, 2, 2}, Affine::Identity()}, Affine::Identity(), 1, context),
      Error);
}

}  // namespace
}  // namespace beatlas::cli
