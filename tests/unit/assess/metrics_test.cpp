// Each figure against a case whose answer is known in closed form.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "pipeline/assess/compare.h"
#include "pipeline/assess/wall_thickness.h"
#include "tests/unit/assess/made_candidate.h"

namespace beatlas::assess {
namespace {

using test::Made;

constexpr auto kBlood = Structure::LvBlood;
constexpr auto kMuscle = Structure::LvMyocardium;

class Still : public ::testing::Test {
 protected:
  Still() : made_(Made::still()) {}

  [[nodiscard]] field::FieldQuery query(Structure structure, const test::Level& level = {}) const {
    return {made_.field(structure, level), made_.manifest.rr_interval_s};
  }
  [[nodiscard]] PhaseErrors compare(const test::Level& level, int phase = 0) const {
    CompareOptions options;
    options.crease_band_mm = 5.0;  // the spline of 2 mm rounds a crease two voxels wide
    return compare_phase(made_.manifest, query(kBlood, level), made_.truth, phase, 4, options);
  }
  /// Mean over the true surface, the same points as the comparison's.
  [[nodiscard]] double mean_over_surface(
      const std::function<double(const Vec3& outward)>& value) const {
    const auto frame = made_.truth.frame(0.0);
    double sum = 0.0;
    int count = 0;
    for (const Vec3& lps : frame->sample_surface(kBlood, 2.0)) {
      if (frame->crease_distance_mm(kBlood, lps) < 5.0) continue;
      sum += value(made_.workspace_from_lps.linear() * frame->nearest(kBlood, lps).outward);
      ++count;
    }
    return sum / count;
  }

  Made made_;
};

TEST_F(Still, TheTruthItselfHasNeitherAngleNorVelocity) {
  const PhaseErrors errors = compare({});
  EXPECT_LT(errors.normal_mean_deg, 0.3);  // of a cubic spline of 2 mm
  EXPECT_LT(errors.normal_p95_deg, 1.0);
  EXPECT_LT(errors.velocity_mean_mm_s, 0.02);  // a step of the coefficients is 0.002 mm
}

TEST_F(Still, ATiltedFieldTurnsNormalsByItsTilt) {
  // phi + g . (x - c): the gradient n + g, so the angle follows from n and g alone.
  const Vec3 tilt = 0.1 * Vec3(1.0, 2.0, -2.0).normalized();
  const Vec3 centre = made_.centre();
  const PhaseErrors errors = compare([&](const Vec3& x, double share) {
    return made_.distance_mm(kBlood, x, share) + tilt.dot(x - centre);
  });
  const double expected = mean_over_surface([&](const Vec3& n) {
    return std::acos(n.dot((n + tilt).normalized())) * 180.0 / std::numbers::pi;
  });
  EXPECT_GT(expected, 3.0);
  EXPECT_NEAR(errors.normal_mean_deg, expected, 0.15);  // the spline, as above
  EXPECT_LT(errors.normal_p95_deg, 6.5);                // asin 0.1 is 5.74 degrees
  EXPECT_GT(errors.normal_p95_deg, expected);
}

TEST_F(Still, AFieldThatSwingsHasTheVelocityOfItsSwing) {
  // Moved by A sin(2 pi share) along u. Through its four samples 0, A, 0, -A the periodic cubic
  // spline passes phase 0 at 6 A a cycle.
  constexpr double kSwingMm = 1.0;
  const Vec3 u = Vec3(2.0, -1.0, 2.0).normalized();
  const double speed = 6.0 * kSwingMm / made_.manifest.rr_interval_s;
  const auto swing = [&](const Vec3& x, double share) {
    const double moved = kSwingMm * std::sin(2.0 * std::numbers::pi * share);
    return made_.distance_mm(kBlood, x - moved * u, share);
  };
  const PhaseErrors errors = compare(swing);
  const double expected =
      mean_over_surface([&](const Vec3& n) { return speed * std::abs(n.dot(u)); });
  EXPECT_GT(expected, 2.0);
  EXPECT_NEAR(errors.velocity_mean_mm_s, expected, 0.03 * expected);
  EXPECT_LT(errors.velocity_p95_mm_s, 1.02 * speed);
  EXPECT_GT(errors.velocity_p95_mm_s, expected);
  EXPECT_LT(errors.rms_mm, 0.05) << "at phase 0 it passes its own place";
  EXPECT_LT(compare(swing, 1).velocity_mean_mm_s, 0.1 * expected) << "it turns at phase 1";
}

TEST_F(Still, TheWallOfTheTruthIsAsThickAsItIs) {
  const ThicknessErrors errors = wall_thickness_errors(
      query(kBlood), query(kMuscle), made_.workspace_from_lps, made_.truth, 0.0, {});
  EXPECT_GT(errors.points, 300);
  EXPECT_EQ(errors.missing, 0);
  EXPECT_LT(errors.mean_mm, 0.03);  // splines of 2 mm of two walls
  EXPECT_LT(std::abs(errors.bias_mm), 0.02);
  // 8.5 mm across and 6 mm at the apex; along the normal, not across.
  EXPECT_GT(errors.true_mean_mm, 6.5);
  EXPECT_LT(errors.true_mean_mm, 9.0);
}

TEST_F(Still, ACavityGrownByAMillimetreThinsTheWallByIt) {
  const auto blood = query(kBlood, [&](const Vec3& x, double share) {
    return made_.distance_mm(kBlood, x, share) - 1.0;
  });
  const ThicknessErrors errors =
      wall_thickness_errors(blood, query(kMuscle), made_.workspace_from_lps, made_.truth, 0.25, {});
  EXPECT_NEAR(errors.bias_mm, -1.0, 0.02);  // along the normal, exactly; the splines beside
  EXPECT_NEAR(errors.mean_mm, 1.0, 0.02);
  EXPECT_NEAR(errors.p95_mm, 1.0, 0.1);
}

TEST_F(Still, AWallThatIsNotThereIsMissing) {
  const auto blood = query(kBlood, [&](const Vec3& x, double share) {
    return made_.distance_mm(kBlood, x, share) + 14.0;  // farther away than it is sought
  });
  const ThicknessErrors errors =
      wall_thickness_errors(blood, query(kMuscle), made_.workspace_from_lps, made_.truth, 0.0, {});
  EXPECT_EQ(errors.points, 0);
  EXPECT_GT(errors.missing, 300);
}

}  // namespace
}  // namespace beatlas::assess
