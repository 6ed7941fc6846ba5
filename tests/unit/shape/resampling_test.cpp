#include <gtest/gtest.h>

#include "pipeline/phantom/cover.h"
#include "pipeline/phantom/render.h"
#include "pipeline/shape/workspace.h"
#include "tests/unit/shape/made_shapes.h"

namespace beatlas::shape {
namespace {

float ramp(const Vec3& lps) {
  return static_cast<float>(500 + 0.7 * lps[0] - 1.1 * lps[1] + 0.4 * lps[2]);
}

TEST(CineInWorkspace, OfALinearRampIsExact) {
  Cine cine;
  cine.images.grid = made::oblique_grid({60, 50, 14}, {1.5, 1.7, 6}, {20, -30, 10});
  const Grid& grid = cine.images.grid;
  cine.images.phases.assign(2, std::vector<float>(grid.count()));
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        cine.images.phases[0][grid.offset(i, j, k)] = ramp(grid.mm(i, j, k));
        cine.images.phases[1][grid.offset(i, j, k)] = -ramp(grid.mm(i, j, k));
      }
    }
  }
  CoverageCycle coverage;
  coverage.grid = grid;
  coverage.phases[Structure::Heart] = {made::ball_coverage(grid, {20, -30, 10}, 15)};
  const Affine map = workspace_from_lps(grid, coverage);
  const ImageCycle<float> out = cine_in_workspace(cine, map);
  EXPECT_EQ(out.grid.size, kWorkspaceSize);
  EXPECT_LT((out.grid.mm(0, 0, 0) - Vec3(0.5, 0.5, 1.5)).norm(), 1e-12);
  ASSERT_EQ(out.phase_count(), 2);
  const Affine index_from_workspace = grid.mm_from_index.inverse() * map.inverse();
  int inside = 0;
  for (int k = 0; k < 64; ++k) {
    for (int j = 0; j < 256; ++j) {
      for (int i = 0; i < 256; ++i) {
        const Vec3 workspace = out.grid.mm(i, j, k);
        const Vec3 x = index_from_workspace * workspace;
        const Vec3 last(59, 49, 13);
        const float value = out.phases[0][out.grid.offset(i, j, k)];
        if ((x.array() < -0.501).any() || (x.array() > last.array() + 0.501).any()) {
          ASSERT_EQ(value, 0);  // beyond the images
        } else if ((x.array() > 0).all() && (x.array() < last.array()).all()) {
          // Single precision of values up to 600.
          ASSERT_NEAR(value, ramp(map.inverse() * workspace), 1e-3);
          ASSERT_NEAR(out.phases[1][out.grid.offset(i, j, k)], -value, 1e-3);
          ++inside;
        }
      }
    }
  }
  // 59 x 1.5 by 49 x 1.7 by 13 x 6 mm in voxels of 3 mm3.
  EXPECT_NEAR(inside, 59 * 1.5 * 49 * 1.7 * 13 * 6 / 3, 0.04 * inside);
}

TEST(CineInWorkspace, OfThePublishedGridIsTheCineItself) {
  Cine cine;
  cine.images.grid = made::oblique_grid({256, 256, 64}, {1, 1, 3}, {5, 6, 7});
  cine.images.phases.assign(1, std::vector<float>(cine.images.grid.count()));
  for (std::size_t v = 0; v < cine.images.phases[0].size(); ++v) {
    cine.images.phases[0][v] = static_cast<float>((v * 7919) % 1009);
  }
  const Affine map = workspace_from_lps(cine.images.grid, {});
  const ImageCycle<float> out = cine_in_workspace(cine, map);
  double worst = 0;
  for (std::size_t v = 0; v < out.phases[0].size(); ++v) {
    worst = std::max<double>(worst, std::abs(out.phases[0][v] - cine.images.phases[0][v]));
  }
  EXPECT_LT(worst, 1e-2);  // indices are whole to 1e-12 of 1000 counts, in single precision
}

TEST(CineInWorkspace, TakesASingleSlice) {
  Cine cine;
  cine.images.grid = made::straight_grid({20, 20, 1}, {2, 2, 6});
  cine.images.phases.assign(1, std::vector<float>(cine.images.grid.count(), 7));
  const Affine map(Eigen::Translation3d(100, 100, 90));
  const ImageCycle<float> out = cine_in_workspace(cine, map);
  EXPECT_EQ(out.phases[0][out.grid.offset(110, 110, 29)], 7);
  EXPECT_EQ(out.phases[0][out.grid.offset(110, 110, 25)], 0);
}

TEST(LabelsInWorkspace, OfAPhantomsExactCoverageAreItsLabels) {
  phantom::PhantomSpec spec = phantom::preset("small");
  spec.anatomy = phantom::ventricles_alone(spec.anatomy);
  spec.phases = 2;
  const phantom::Phantom phantom(spec);
  const Grid grid = spec.imaging_grid();
  Segmentation segmentation = made::segmentation_of(grid, 1);
  const auto frame = phantom.frame(0);
  const Structure all[] = {Structure::Heart, Structure::LvBlood, Structure::RvBlood,
                           Structure::LvMyocardium};
  std::vector<phantom::Body> bodies;
  for (Structure structure : all) {
    phantom::Body& body = bodies.emplace_back();
    body.surface = [&frame, structure](const Vec3& x) {
      const auto nearest = frame->nearest(structure, x);
      return phantom::SignedPlane{nearest.distance_mm, nearest.outward};
    };
    body.inside = [&frame, structure](const Vec3& x) { return frame->contains(structure, x); };
    segmentation.coverage.phases[structure] = {std::vector<float>(grid.count(), 0)};
  }
  for (const phantom::Block& block : phantom::blocks_of(grid, {8, 8, 8})) {
    phantom::cover(
        grid, block, bodies, {}, [&](const phantom::Block& part, const phantom::Shares& shares) {
          for (int k = part.first[2]; k < part.first[2] + part.size[2]; ++k) {
            for (int j = part.first[1]; j < part.first[1] + part.size[1]; ++j) {
              for (int i = part.first[0]; i < part.first[0] + part.size[0]; ++i) {
                for (std::size_t s = 0; s < 4; ++s) {
                  segmentation.coverage.phases[all[s]][0][grid.offset(i, j, k)] = shares[s];
                }
              }
            }
          }
        });
  }
  const Affine map = workspace_from_lps(grid, segmentation.coverage);
  StageContext context;
  const auto shapes = shapes_in_workspace(segmentation, map, {}, context);
  const LabelCycle labels = labels_in_workspace(shapes);
  EXPECT_EQ(labels.grid.size, kWorkspaceSize);
  const Affine lps_from_workspace = map.inverse();
  for (Structure structure : all) {
    double both = 0;
    double sum = 0;
    for (int k = 0; k < 64; ++k) {
      for (int j = 0; j < 256; ++j) {
        for (int i = 0; i < 256; ++i) {
          const std::uint8_t label = labels.phases[0][labels.grid.offset(i, j, k)];
          const std::uint8_t truth = frame->label_at(lps_from_workspace * labels.grid.mm(i, j, k));
          const bool a = label_in_structure(label, structure);
          const bool b = label_in_structure(truth, structure);
          both += a && b;
          sum += static_cast<double>(a) + static_cast<double>(b);
        }
      }
    }
    // Voxels of 2 x 2 x 4 mm, smoothed by 1 mm: walls of 8 mm lose most by it.
    EXPECT_GT(2 * both / sum, structure == Structure::LvMyocardium ? 0.95 : 0.975)
        << structure_name(structure);
    std::cout << structure_name(structure) << " Dice " << 2 * both / sum << "\n";
  }
}

TEST(LabelsInWorkspace, OfNoShapesAreNone) { EXPECT_EQ(labels_in_workspace({}).phase_count(), 0); }

}  // namespace
}  // namespace beatlas::shape
