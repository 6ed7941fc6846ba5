// Vertices against the phantom's muscle: surfaces of its exact shape, with torsion.

#include <algorithm>

#include <gtest/gtest.h>

#include "pipeline/assess/motion_error.h"
#include "pipeline/core/parallel.h"
#include "pipeline/field/field.h"
#include "pipeline/mesh/mesh.h"
#include "pipeline/phantom/phantom.h"

namespace beatlas::mesh {
namespace {

constexpr int kPhases = 8;

// The heart frame is the workspace.
FieldCycle exact_field(const phantom::Phantom& truth, Structure structure) {
  const Affine lps_from_heart = phantom::lps_from_heart(truth.spec().anatomy);
  ShapeCycle shape;
  shape.structure = structure;
  constexpr double kHalfMm = 54;
  constexpr double kEdgeMm = 1.5;
  const int side = static_cast<int>(2 * kHalfMm / kEdgeMm) + 1;
  shape.level.grid.size = {side, side, side};
  shape.level.grid.mm_from_index.linear() *= kEdgeMm;
  shape.level.grid.mm_from_index.translation() =
      truth.spec().anatomy.scale * Vec3(0, 0, -17) - Vec3::Constant(kHalfMm);
  shape.level.phases.resize(kPhases);
  parallel_for(kPhases, [&](std::size_t p) {
    const auto frame = truth.frame(truth.spec().rr_interval_s * static_cast<double>(p) / kPhases);
    std::vector<float>& level = shape.level.phases[p];
    level.resize(shape.level.grid.count());
    for (int k = 0; k < side; ++k) {
      for (int j = 0; j < side; ++j) {
        for (int i = 0; i < side; ++i) {
          level[shape.level.grid.offset(i, j, k)] = static_cast<float>(
              frame->distance_mm(structure, lps_from_heart * shape.level.grid.mm(i, j, k)));
        }
      }
    }
  });
  StageContext context;
  return field::build_field(shape, {}, context);
}

class Motion : public ::testing::TestWithParam<const char*> {};

TEST_P(Motion, AlongTheWallIsAtMostHalfAsWrongAsAlongNormalsAlone) {
  phantom::PhantomSpec spec = phantom::preset(GetParam());
  spec.anatomy.torsion_deg = 12;
  const phantom::Phantom truth(spec);
  const Affine workspace_from_lps = phantom::lps_from_heart(spec.anatomy).inverse(Eigen::Isometry);
  for (const Structure structure : {Structure::LvBlood, Structure::LvMyocardium}) {
    StageContext context;
    SurfaceCycle surface = mesh_cycle(exact_field(truth, structure), {}, context);
    const assess::MotionErrors errors = assess::motion_errors(
        {structure, surface.triangles, surface.positions}, workspace_from_lps, truth, {});
    EXPECT_GT(errors.points, 1000);
    EXPECT_GT(errors.normal_only_tangential_mean_mm, 2.0);
    EXPECT_LT(errors.tangential_share, 0.5);
    EXPECT_LT(errors.mean_mm, 1.5);  // the published median of 3-D tracking
    EXPECT_LT(errors.p95_mm, 4.0);
    RecordProperty(std::string(structure_name(structure)) + "_share_percent",
                   static_cast<int>(100 * errors.tangential_share));
  }
}

INSTANTIATE_TEST_SUITE_P(OfPhantoms, Motion, ::testing::Values("small", "adult"));

}  // namespace
}  // namespace beatlas::mesh
