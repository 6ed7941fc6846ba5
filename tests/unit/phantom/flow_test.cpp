#include <cmath>

#include <gtest/gtest.h>

#include "pipeline/phantom/arms.h"
#include "pipeline/phantom/flow_void.h"
#include "pipeline/phantom/motion.h"
#include "tests/unit/phantom/scanner_images.h"

namespace beatlas::phantom {
namespace {

TEST(PhantomFlow, RateFollowsTheVolumeAndRestsElsewhere) {
  double highest = 0;
  double sum = 0;
  constexpr int kSteps = 7500;
  for (int n = 0; n < kSteps; ++n) {
    const double t = 0.75 * n / kSteps;
    const double rate = ejection_rate(t, 0.75);
    highest = std::max(highest, rate);
    sum += rate;
    if (t < 0.049 || t > 0.331) {
      EXPECT_EQ(rate, 0.0) << t;
    }
  }
  EXPECT_NEAR(highest, 1.0, 1e-4);
  // The rate's integral is the loss of 1: mean over the cycle times the highest rate.
  const double peak =
      (volume_loss(0.17, 0.75) - volume_loss(0.169, 0.75)) / 1e-3 / ejection_rate(0.1695, 0.75);
  EXPECT_NEAR(peak * 0.75 * sum / kSteps, 1.0, 2e-3);
  EXPECT_NEAR(ejection_rate(0.2, 0.75), ejection_rate(0.24, 0.9), 1e-9);
}

TEST(PhantomFlow, TheJetIsAConeAboveItsTip) {
  const HeartShape shape = heart_shape(Anatomy{}, 0.5);
  const JetCone cone = jet_cone(shape, 1.0);
  EXPECT_LT(cone.tip.z(), shape.lv_base_z_mm);
  EXPECT_GT(cone.tip.z() + cone.length_mm, shape.lv_base_z_mm);
  const double z = shape.lv_base_z_mm;
  const double radius = cone.slope * (z - cone.tip.z());
  EXPECT_EQ(jet_weight(cone, {cone.tip.x(), cone.tip.y(), z}), 1.0);
  EXPECT_EQ(jet_weight(cone, {cone.tip.x() + radius + 2.5, cone.tip.y(), z}), 0.0);
  EXPECT_NEAR(jet_weight(cone, {cone.tip.x() + radius, cone.tip.y(), z}), 0.5, 1e-9);
  EXPECT_EQ(jet_weight(cone, cone.tip - Vec3(0, 0, 3)), 0.0);
  EXPECT_EQ(jet_weight(cone, cone.tip + Vec3(0, 0, cone.length_mm + 2)), 0.0);
}

TEST(PhantomFlow, VoidTakesHalfOfTheBloodsSignalInTheJetDuringEjection) {
  PhantomSpec spec = test::of_centres(2.0);
  spec.grid = on_matrix(preset("small").grid, {80, 80, 34}, {2.0, 2.0, 5.0});
  const auto plain = test::images_of(spec);
  spec.scanner.flow_void_share = 0.5;
  const auto empty = test::images_of(spec);
  const Phantom phantom(spec);
  const Grid grid = spec.imaging_grid();
  const Affine heart_from_lps = lps_from_heart(spec.anatomy).inverse();
  for (int p = 0; p < spec.phases; ++p) {
    const double t = phantom.phase_time_s(p);
    const double rate = ejection_rate(t, spec.rr_interval_s);
    if (rate == 0.0) {
      EXPECT_EQ(empty[p], plain[p]);
      continue;
    }
    const JetCone cone = jet_cone(phantom.frame(t)->shape(), spec.anatomy.scale);
    int changed = 0;
    test::for_each_index(grid, [&](int i, int j, int k) {
      const Vec3 x = grid.mm(i, j, k);
      const std::size_t voxel = grid.offset(i, j, k);
      const double weight = jet_weight(cone, heart_from_lps * x);
      const double kept = plain[p][voxel] == kBloodCounts ? 1.0 - 0.5 * rate * weight : 1.0;
      // The descending aorta has blood's signal, too, but lies in no jet.
      ASSERT_NEAR(empty[p][voxel], kept * plain[p][voxel], 0.51);
      changed += kept < 1.0 - 0.25 * rate;
    });
    EXPECT_GT(changed, 10) << "phase " << p << " rate " << rate;
  }
}

TEST(PhantomArms, AppearMovedByTheFieldOfView) {
  PhantomSpec spec = test::of_centres();
  const auto plain = test::images_of(spec);
  spec.scanner.arms = true;
  const auto folded = test::images_of(spec);
  const Grid grid = spec.imaging_grid();
  const Signals signals;
  const auto tissues = arms(spec.anatomy, signals);
  const double field_mm = grid.size[0] * grid.spacing_mm().x();
  const auto arm_at = [&](const Vec3& x) {
    double signal = 0.0;
    for (const ThoraxBody& tissue : tissues) {
      if (tissue.surface(x).distance_mm < 0.0) signal = tissue.signal;
    }
    return 1000.0 * signal;
  };
  int left = 0;
  int right = 0;
  test::for_each_index(grid, [&](int i, int j, int k) {
    const Vec3 x = grid.mm(i, j, k);
    const double from_left = arm_at(x + Vec3(field_mm, 0, 0));
    const double from_right = arm_at(x - Vec3(field_mm, 0, 0));
    const double more = arm_at(x) + from_left + from_right;
    for (int p : {0, 2}) {
      ASSERT_NEAR(folded[p][grid.offset(i, j, k)], plain[p][grid.offset(i, j, k)] + more, 0.51);
    }
    left += from_left > 0;
    right += from_right > 0;
  });
  EXPECT_GT(left, 500);
  EXPECT_GT(right, 500);
}

TEST(PhantomArms, FoldAlongThePhaseEncodingAxisOnly) {
  PhantomSpec spec = test::of_centres();
  const auto plain = test::images_of(spec);
  spec.scanner.arms = true;
  // Columns do not repeat, and the arms lie beside the field of view but for their edge.
  spec.scanner.phase_encoding = std::string("j");
  const auto columns = test::images_of(spec);
  const Grid grid = spec.imaging_grid();
  test::for_each_index(grid, [&](int i, int j, int k) {
    if (std::abs(grid.mm(i, j, k).x()) > 175.0 - 36.0 - 1.0) return;
    ASSERT_EQ(columns[0][grid.offset(i, j, k)], plain[0][grid.offset(i, j, k)]);
  });
}

}  // namespace
}  // namespace beatlas::phantom
