#include "pipeline/assess/motion_error.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "pipeline/phantom/material.h"
#include "pipeline/phantom/motion.h"
#include "tests/unit/assess/made_candidate.h"

namespace beatlas::assess {
namespace {

using test::Made;

constexpr double kTorsionDeg = 12.0;

Made turning_heart() {
  phantom::PhantomSpec spec = Made::small();
  spec.phases = 6;
  spec.anatomy.torsion_deg = kTorsionDeg;
  return Made(spec);
}

/// Vertices on both faces of the LV's wall that move with its muscle, and some at the base, which
/// do not count. `turn_share` of the true torsion; `shift_mm` along the long axis in every phase
/// but the first.
atlas::SurfacePayload muscle_points(const Made& made, double turn_share, double shift_mm = 0) {
  phantom::Anatomy anatomy = made.truth.spec().anatomy;
  anatomy.torsion_deg *= turn_share;
  const Affine place = made.workspace_from_lps * phantom::lps_from_heart(anatomy);
  atlas::SurfacePayload out;
  out.structure = Structure::LvMyocardium;
  const int phases = made.truth.spec().phases;
  for (int p = 0; p < phases; ++p) {
    const double rr_s = made.truth.spec().rr_interval_s;
    const double s = std::clamp(phantom::volume_loss(rr_s * p / phases, rr_s), 0.0, 1.0);
    std::vector<Vec3f>& at = out.positions.emplace_back();
    for (double height : {0.15, 0.3, 0.5, 0.7, 1.0}) {
      for (double angle : {0.2, 1.5, 2.9, 4.4}) {
        for (double mural : {0.0, 1.0}) {
          Vec3 x = phantom::position_mm(anatomy, {height, angle, mural}, s);
          if (p > 0) x.z() += shift_mm;
          at.push_back((place * x).cast<float>());
        }
      }
    }
  }
  return out;
}

TEST(MotionErrors, OfPointsThatAreTheMuscleThereAreNone) {
  const Made made = turning_heart();
  const MotionErrors found =
      motion_errors(muscle_points(made, 1.0), made.workspace_from_lps, made.truth, {});
  EXPECT_EQ(found.points, 4 * 4 * 2);
  EXPECT_LT(found.p95_mm, 1e-4);  // floats of 128 mm
  EXPECT_LT(found.tangential_share, 1e-4);
  EXPECT_GT(found.normal_only_tangential_mean_mm, 2.0);
}

TEST(MotionErrors, AShiftIsFoundAndItsPartAlongTheWall) {
  const Made made = turning_heart();
  const MotionErrors found =
      motion_errors(muscle_points(made, 1.0, 1.5), made.workspace_from_lps, made.truth, {});
  EXPECT_NEAR(found.mean_mm, 1.5, 1e-4);
  EXPECT_NEAR(found.p95_mm, 1.5, 1e-4);
  // Along the axis: nearly along the side wall, across it near the apex.
  EXPECT_LT(found.tangential_mean_mm, 1.49);
  EXPECT_GT(found.tangential_mean_mm, 1.0);
}

TEST(MotionErrors, TorsionThatIsLeftOutIsFound) {
  const Made made = turning_heart();
  const MotionErrors found =
      motion_errors(muscle_points(made, 0.0), made.workspace_from_lps, made.truth, {});
  // A chord of the turn, all of it along the wall.
  const phantom::Anatomy& anatomy = made.truth.spec().anatomy;
  double sum = 0;
  int count = 0;
  for (int p = 1; p < made.truth.spec().phases; ++p) {
    const double rr_s = made.truth.spec().rr_interval_s;
    const double s =
        std::clamp(phantom::volume_loss(rr_s * p / made.truth.spec().phases, rr_s), 0.0, 1.0);
    for (double height : {0.15, 0.3, 0.5, 0.7}) {
      for (double mural : {0.0, 1.0}) {
        const double radius =
            phantom::position_mm(anatomy, {height, 0.0, mural}, s).head<2>().norm();
        sum += 2 * radius * std::sin(0.5 * (1 - height) * s * kTorsionDeg * M_PI / 180);
        ++count;
      }
    }
  }
  EXPECT_NEAR(found.mean_mm, sum / count, 1e-3);
  EXPECT_NEAR(found.tangential_mean_mm, found.mean_mm, 1e-3 + 0.02 * found.mean_mm);
}

TEST(MotionErrors, AreNoneWhereNoVertexIsOnTheWall) {
  const Made made = turning_heart();
  atlas::SurfacePayload away = muscle_points(made, 1.0);
  for (auto& phase : away.positions) {
    for (Vec3f& x : phase) x += Vec3f(0, 0, 400);
  }
  EXPECT_EQ(motion_errors(away, made.workspace_from_lps, made.truth, {}).points, 0);
  phantom::PhantomSpec infarct = made.truth.spec();
  infarct.anatomy.infarct.present = true;
  EXPECT_EQ(motion_errors(muscle_points(made, 1.0), made.workspace_from_lps,
                          phantom::Phantom(infarct), {})
                .points,
            0);
}

}  // namespace
}  // namespace beatlas::assess
