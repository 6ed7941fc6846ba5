/// From which phase a cycle is meshed.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "pipeline/mesh/levels.h"
#include "pipeline/mesh/mesh.h"
#include "tests/unit/mesh/beating_shapes.h"
#include "tests/unit/mesh/expect_sound.h"

namespace beatlas::mesh {
namespace {

using closed_form::beating_field;

/// A ball with a wide pit that is open at share 0 and shuts soon after.
double pitted_ball(double share, const Vec3& x) {
  const double open = 1 - std::pow(share, 0.3);
  const closed_form::Ellipsoid pit{{0, 0, 26}, {18 * open + 0.5, 8 * open + 0.5, 38 * open + 1.6}};
  return std::max(x.norm() - 24, -closed_form::ellipsoid_level(pit, x));
}

FieldCycle pitted_field() { return beating_field(pitted_ball, 8, {-26, -26, -26}, {26, 26, 26}); }

/// Of the worst phase.
struct Thin {
  double least_deg = 180;
  double percentile_deg = 180;
};
Thin thin_of(const SurfaceCycle& surface) {
  Thin out;
  for (const PhaseQuality& phase : measure_quality(surface).phases) {
    out.least_deg = std::min(out.least_deg, phase.least_angle_deg);
    out.percentile_deg = std::min(out.percentile_deg, phase.percentile_1_angle_deg);
  }
  return out;
}

TEST(ReferencePhase, KeepsTrianglesSoundWhereAPitShuts) {
  const FieldCycle field = pitted_field();
  StageContext context;
  MeshOptions first;
  first.reference_phase = 0;
  const Thin of_first = thin_of(mesh_cycle(field, first, context));
  const SurfaceCycle chosen = mesh_cycle(field, {}, context);
  expect_sound(chosen);
  const Thin of_chosen = thin_of(chosen);
  const SurfaceError error = error_against(field, chosen);
  std::cout << "first percentile of angles " << of_first.percentile_deg << " deg from the first, "
            << of_chosen.percentile_deg << " from the chosen, least " << of_first.least_deg
            << " and " << of_chosen.least_deg << "; mean error " << error.mean_mm << " mm\n";
  // It is the first phase that makes the slivers: what is asked of every surface fails from there.
  EXPECT_LT(of_first.percentile_deg, 20.0);
  EXPECT_LT(error.mean_mm, 0.1);
  MeshOptions coarse;
  coarse.edge_mm = 4;
  expect_sound(level_of_detail(chosen, field, coarse, context));
}

/// Two balls of 13 and 11 mm, the second on a stalk that is not there at share 0: a piece apart.
/// @param apart_mm from ball to ball
double stalked_ball(double share, const Vec3& x, double apart_mm) {
  const double ball = (x - Vec3(-12, 0, 0)).norm() - 13;
  const double other = (x - Vec3(12 + apart_mm, 0, 0)).norm() - 11;
  const double middle = 1 + 0.5 * apart_mm;
  const double stalk = std::max(std::hypot(x.y(), x.z()) - (share < 0.05 ? -3.0 : 2.5),
                                std::abs(x.x() - middle) - 0.5 * apart_mm - 6);
  return std::min({ball, other, stalk});
}

double ball_ml(double radius_mm) {
  return 4.0 / 3 * std::numbers::pi * std::pow(radius_mm, 3) / 1000;
}

/// The mesh of the first phase, carried on.
SurfaceCycle meshed_from_first(double apart_mm, field::Handles handles, std::string& told) {
  const FieldCycle field = beating_field(
      [apart_mm](double share, const Vec3& x) { return stalked_ball(share, x, apart_mm); }, 8,
      {-26, -15, -15}, {24 + apart_mm, 15, 15}, handles);
  StageContext context;
  context.warn_sink = [&](std::string_view text) { told += std::string(text) + "\n"; };
  MeshOptions first;
  first.reference_phase = 0;
  return mesh_cycle(field, first, context);
}

TEST(ReferencePhase, SaysWhatAMeshNeverReached) {
  // Of pieces that are kept the largest is meshed, and the second ball has no stalk there.
  std::string told;
  const SurfaceCycle surface = meshed_from_first(14, field::Handles::Keep, told);
  // The vertices lie on the surface of the first ball, and the second, stalk and all, is 40 % of
  // the whole.
  EXPECT_NEAR(measure_quality(surface).phases[4].volume_ml, ball_ml(13), 0.1 * ball_ml(13));
  EXPECT_NE(told.find("differ by 40 % of volume in phase "), std::string::npos) << told;
}

TEST(ReferencePhase, ReachesAPartThatLostItsNeckInThatPhase) {
  // The other phases say that it belongs to the body, also where it is farther away than deep.
  for (const double apart_mm : {4.0, 14.0}) {
    std::string told;
    const SurfaceCycle surface = meshed_from_first(apart_mm, field::Handles::Close, told);
    const double both_ml = ball_ml(13) + ball_ml(11);
    for (const int phase : {0, 4}) {
      EXPECT_NEAR(measure_quality(surface).phases[static_cast<std::size_t>(phase)].volume_ml,
                  both_ml, 0.05 * both_ml)
          << phase << " of " << apart_mm;
    }
    EXPECT_EQ(told.find("differ by "), std::string::npos) << told;
  }
}

}  // namespace
}  // namespace beatlas::mesh
