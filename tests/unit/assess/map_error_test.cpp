#include "pipeline/assess/map_error.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "runtime/palpation/segments.h"
#include "tests/unit/assess/made_candidate.h"

namespace beatlas::assess {
namespace {

/// A surface of the truth's own points with what a map without error would say of them, found by
/// going through the muscle in small steps.
struct Mapped {
  explicit Mapped(const test::Made& made, Structure structure) {
    const phantom::Phantom& truth = made.truth;
    const phantom::Anatomy& anatomy = truth.spec().anatomy;
    const Affine heart_from_lps = phantom::lps_from_heart(anatomy).inverse();
    surface.structure = map.structure = structure;
    const auto frame = truth.frame(0);
    const double apex_mm = anatomy.scale * anatomy.apex_mm;
    const std::vector<Vec3> points = frame->sample_surface(structure, 5.0);
    const auto phases = static_cast<std::size_t>(truth.spec().phases);
    surface.positions.resize(phases);
    map.thickness_mm.resize(phases);
    for (const Vec3& lps : points) {
      const Vec3 heart_mm = heart_from_lps * lps;
      const double share = (heart_mm.z() - apex_mm) / (frame->shape().lv_base_z_mm - apex_mm);
      const double angle = std::atan2(heart_mm.x(), heart_mm.y());
      map.long_axis.push_back(static_cast<float>(std::clamp(share, 0.0, 1.0)));
      map.angle_rad.push_back(static_cast<float>(angle));
      map.segment.push_back(static_cast<std::uint8_t>(palpation::segment_at(share, angle)));
      const Vec3 inner = frame->nearest(Structure::LvBlood, lps).point;
      const Vec3 along = (lps - inner).norm() < 1e-5
                             ? frame->nearest(Structure::LvBlood, lps).outward
                             : Vec3((lps - inner).normalized());
      double wall_mm = 0;
      while (wall_mm < 40 &&
             frame->contains(Structure::LvMyocardium, inner + (wall_mm + 0.01) * along)) {
        wall_mm += 0.01;
      }
      for (std::size_t p = 0; p < phases; ++p) {
        surface.positions[p].push_back((made.workspace_from_lps * lps).cast<float>());
        map.thickness_mm[p].push_back(static_cast<float>(wall_mm));
      }
    }
  }

  [[nodiscard]] MapErrors errors(const test::Made& made) const {
    return map_errors(map, surface, made.workspace_from_lps, made.truth, {});
  }

  atlas::SurfacePayload surface;
  atlas::SurfaceMapPayload map;
};

class MapError : public ::testing::TestWithParam<Structure> {
 protected:
  test::Made made_{test::Made::still()};
  Mapped mapped_{made_, GetParam()};
};

TEST_P(MapError, OfTheTruthItselfIsNone) {
  const MapErrors errors = mapped_.errors(made_);
  EXPECT_GT(errors.points, 1000);
  EXPECT_EQ(errors.missing, 0);
  EXPECT_LT(errors.thickness_mean_mm, 0.011);  // of the steps
  EXPECT_LT(errors.thickness_p95_mm, 0.02);
  EXPECT_GT(errors.named, 300);
  EXPECT_GT(errors.segments_percent, 98.5);  // samples on a border may round to either side
  EXPECT_NEAR(errors.thickness_true_mean_mm, 8.5, 2);
}

TEST_P(MapError, TellsHowMuchTooThickAMapIs) {
  for (auto& phase : mapped_.map.thickness_mm) {
    for (float& mm : phase) mm += mm > 0 ? 0.4F : 0;
  }
  for (float& mm : mapped_.map.thickness_mm[1]) mm -= mm > 0 ? 1.2F : 0;  // one phase of four
  const MapErrors errors = mapped_.errors(made_);
  EXPECT_NEAR(errors.thickness_bias_mm, 0.1, 0.02);
  EXPECT_NEAR(errors.thickness_mean_mm, 0.5, 0.02);
  EXPECT_NEAR(errors.thickness_p95_mm, 0.8, 0.03);
}

TEST_P(MapError, TellsHolesAndWrongNames) {
  for (std::size_t v = 0; v < mapped_.map.segment.size(); ++v) {
    if (v % 4 == 0) mapped_.map.segment[v] = mapped_.map.segment[v] == 1 ? 2 : 1;
    if (v % 2 == 1) mapped_.map.thickness_mm[2][v] = 0;
  }
  const MapErrors errors = mapped_.errors(made_);
  EXPECT_NEAR(errors.segments_percent, 75, 5);
  EXPECT_NEAR(static_cast<double>(errors.missing) / (errors.points + errors.missing), 0.125, 0.02);
}

/// The RV's free wall, which the phantom makes as thick as it is told along every semi-axis.
struct MappedRv {
  explicit MappedRv(const test::Made& made) {
    surface.structure = map.structure = Structure::RvBlood;
    const auto frame = made.truth.frame(0);
    const auto phases = static_cast<std::size_t>(made.truth.spec().phases);
    surface.positions.resize(phases);
    map.thickness_mm.resize(phases);
    for (const Vec3& lps : frame->sample_surface(Structure::RvBlood, 5.0)) {
      const Vec3 outward = frame->nearest(Structure::RvBlood, lps).outward;
      double wall_mm = 0.005;
      while (wall_mm < 40 && frame->contains(phantom::Part::RvWall, lps + wall_mm * outward)) {
        wall_mm += 0.01;
      }
      map.long_axis.push_back(0.5F);
      map.angle_rad.push_back(1);
      map.segment.push_back(0);
      for (std::size_t p = 0; p < phases; ++p) {
        surface.positions[p].push_back((made.workspace_from_lps * lps).cast<float>());
        map.thickness_mm[p].push_back(static_cast<float>(wall_mm));
      }
    }
  }
  atlas::SurfacePayload surface;
  atlas::SurfaceMapPayload map;
};

TEST(MapErrorOfTheRv, IsOfItsFreeWallAndOfNoSegments) {
  const test::Made made{test::Made::still()};
  MappedRv mapped(made);
  const auto errors = [&] {
    return map_errors(mapped.map, mapped.surface, made.workspace_from_lps, made.truth, {});
  };
  MapErrors found = errors();
  EXPECT_GT(found.points, 500);
  EXPECT_EQ(found.missing, 0);
  EXPECT_EQ(found.named, 0);
  EXPECT_LT(found.thickness_mean_mm, 0.011);  // of the steps
  EXPECT_LT(found.thickness_p95_mm, 0.02);
  EXPECT_NEAR(found.thickness_true_mean_mm, made.truth.spec().anatomy.rv_wall_mm, 0.5);
  // The septum is no free wall: nothing is asked there, whatever the map says of it.
  const int all = static_cast<int>(mapped.map.segment.size()) * made.truth.spec().phases;
  EXPECT_LT(found.points, 0.8 * all);
  for (auto& phase : mapped.map.thickness_mm) {
    for (std::size_t v = 0; v < phase.size(); v += 2) phase[v] = 0;
    for (float& mm : phase) mm += mm > 0 ? 0.5F : 0;
  }
  found = errors();
  EXPECT_NEAR(found.thickness_bias_mm, 0.5, 0.011);
  EXPECT_NEAR(static_cast<double>(found.missing) / (found.points + found.missing), 0.5, 0.05);
}

INSTANTIATE_TEST_SUITE_P(Of, MapError,
                         ::testing::Values(Structure::LvBlood, Structure::LvMyocardium),
                         [](const auto& of) { return std::string(structure_name(of.param)); });

}  // namespace
}  // namespace beatlas::assess
