#include "pipeline/cli/source_labels.h"

#include <cmath>
#include <memory>
#include <numbers>

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

/// The same as a surface, 0.02 mm within it at most: rings about its poles.
std::shared_ptr<const atlas::SurfacePayload> ball_surface(Structure structure, double largest_mm) {
  constexpr std::uint32_t kRings = 60;
  constexpr std::uint32_t kColumns = 120;
  atlas::SurfacePayload out;
  out.structure = structure;
  for (int phase = 0; phase < kPhases; ++phase) {
    std::vector<Vec3f>& points = out.positions.emplace_back();
    const auto put = [&](double polar, double turn) {
      const Vec3 away(std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn),
                      std::cos(polar));
      points.push_back((kCentre + radius_mm(largest_mm, phase) * away).cast<float>());
    };
    put(0, 0);
    for (std::uint32_t ring = 1; ring < kRings; ++ring) {
      for (std::uint32_t n = 0; n < kColumns; ++n) {
        put(std::numbers::pi * ring / kRings, 2 * std::numbers::pi * n / kColumns);
      }
    }
    put(std::numbers::pi, 0);
  }
  const auto at = [](std::uint32_t ring, std::uint32_t n) {
    return 1 + (ring - 1) * kColumns + n % kColumns;
  };
  const std::uint32_t last = 1 + (kRings - 1) * kColumns;
  for (std::uint32_t n = 0; n < kColumns; ++n) {
    out.triangles.push_back({0, at(1, n), at(1, n + 1)});
    for (std::uint32_t ring = 1; ring + 1 < kRings; ++ring) {
      out.triangles.push_back({at(ring, n), at(ring + 1, n), at(ring + 1, n + 1)});
      out.triangles.push_back({at(ring, n), at(ring + 1, n + 1), at(ring, n + 1)});
    }
    out.triangles.push_back({last, at(kRings - 1, n + 1), at(kRings - 1, n)});
  }
  return std::make_shared<atlas::SurfacePayload>(std::move(out));
}

/// Of balls about one centre, on an oblique grid: the inner one's label within it.
void expect_balls(const Shapes& shapes, double heart_mm, double inner_mm, Label inner) {
  const Affine workspace_from_lps =
      Eigen::Translation3d(60, 60, 60) * Eigen::AngleAxisd(0.7, Vec3(1, -2, 1).normalized());
  Grid grid{{50, 40, 12}, Affine::Identity()};
  grid.mm_from_index.linear() =
      Eigen::AngleAxisd(0.3, Vec3::UnitX()).toRotationMatrix() * Vec3(1.7, 1.9, 8).asDiagonal();
  grid.mm_from_index.translation() = -(grid.mm_from_index.linear() * Vec3(24, 20, 6));
  StageContext context;
  const LabelCycle labels = labels_from_shapes(shapes, grid, workspace_from_lps, 0.8, context);
  ASSERT_EQ(labels.phase_count(), kPhases);
  std::size_t inside = 0;
  for (int p = 0; p < kPhases; ++p) {
    for (int k = 0; k < 12; ++k) {
      for (int j = 0; j < 40; ++j) {
        for (int i = 0; i < 50; ++i) {
          const double r = grid.mm(i, j, k).norm();  // the ball's centre is the LPS origin
          const double heart = r - radius_mm(heart_mm, p);
          const double cavity = r - radius_mm(inner_mm, p);
          // A field is coded to 0.01 mm and exact for a ball to about 0.02 mm.
          if (std::abs(heart) < 0.1 || std::abs(cavity) < 0.1) continue;
          const int expected = cavity < 0  ? inner
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

TEST(SourceLabels, AreTheSignsOfTheFieldsOnAnObliqueGrid) {
  expect_balls({{ball(Structure::Heart, 30), ball(Structure::LvBlood, 18)}, {}}, 30, 18,
               kLabelLvBlood);
}

// As of an atrium, which has no field; and of a package of surfaces, whose order says nothing.
TEST(SourceLabels, AreWhatSurfacesEncloseWhereThereIsNoField) {
  expect_balls({{ball(Structure::Heart, 30)}, {ball_surface(Structure::LaBlood, 18)}}, 30, 18,
               kLabelLaBlood);
  const auto heart = ball_surface(Structure::Heart, 30);
  const auto aorta = ball_surface(Structure::Aorta, 18);
  expect_balls({{}, {heart, aorta}}, 30, 18, kLabelAorta);
  expect_balls({{}, {aorta, heart}}, 30, 18, kLabelAorta);
}

TEST(SourceLabels, OfAFieldStayWhereASurfaceOverlapsIt) {
  expect_balls({{ball(Structure::Heart, 30), ball(Structure::LvBlood, 18)},
                {ball_surface(Structure::RaBlood, 17)}},
               30, 18, kLabelLvBlood);
}

TEST(SourceLabels, NeedShapesOfTheSamePhases) {
  StageContext context;
  const Grid grid{{2, 2, 2}, Affine::Identity()};
  EXPECT_THROW((void)labels_from_shapes({}, grid, Affine::Identity(), 1, context), Error);
  auto still = *ball_surface(Structure::LaBlood, 18);
  still.positions.resize(1);
  const Shapes shapes{{ball(Structure::Heart, 30)},
                      {std::make_shared<atlas::SurfacePayload>(std::move(still))}};
  EXPECT_THROW((void)labels_from_shapes(shapes, grid, Affine::Identity(), 1, context), Error);
}

}  // namespace
}  // namespace beatlas::cli
