#include "pipeline/cli/stored_images.h"

#include <cmath>

#include <gtest/gtest.h>

#include "pipeline/build/heart_images.h"
#include "pipeline/pack/volume_encoder.h"
#include "runtime/atlas/volume_payload.h"

namespace beatlas::cli {
using build::box_around;
using build::cut_images;
using build::HeartImages;
using build::StackBox;
namespace {

/// An oblique stack of 40 x 36 x 12 voxels of 1.5 x 1.5 x 6 mm; every voxel's value tells its
/// place.
ImageCycle<float> stack() {
  ImageCycle<float> out;
  out.grid.size = {40, 36, 12};
  out.grid.mm_from_index = Eigen::Translation3d(-30, 12, 55) *
                           Eigen::AngleAxisd(0.6, Vec3(1, 2, -1).normalized()) *
                           Eigen::Scaling(1.5, 1.5, 6.0);
  for (int p = 0; p < 3; ++p) {
    std::vector<float> phase;
    for (int n = 0; n < 40 * 36 * 12; ++n) {
      phase.push_back(float(10 * (n % 40) + 7 * (n / 40 % 36) + 20 * (n / 1440) + 5 * p));
    }
    out.phases.push_back(std::move(phase));
  }
  return out;
}

Affine workspace_from_lps() {
  return Eigen::Translation3d(100, 90, 40) * Eigen::AngleAxisd(-0.4, Vec3(2, 1, 1).normalized());
}

/// A ball of 12 mm around a voxel of the stack, on a lattice of the workspace that reaches 6 mm on.
FieldCycle ball(const Vec3& centre) {
  FieldCycle out;
  out.structure = Structure::Heart;
  out.voxel_mm = 1.5;
  out.inner_mm = out.outer_mm = 6;
  Grid& grid = out.distance_mm.grid;
  grid.size = {25, 25, 25};
  grid.mm_from_index = Eigen::Translation3d(centre - Vec3::Constant(18)) * Eigen::Scaling(1.5);
  std::vector<float> distance;
  for (int n = 0; n < 25 * 25 * 25; ++n) {
    const Vec3 at = grid.mm(n % 25, n / 25 % 25, n / 625);
    distance.push_back(float(std::clamp((at - centre).norm() - 12, -6.0, 6.0)));
  }
  out.distance_mm.phases.assign(3, distance);
  return out;
}

TEST(HeartImages, HoldEveryVoxelWhoseCentreLiesInTheLatticeAndFewMore) {
  const ImageCycle<float> images = stack();
  const Affine workspace_from_index = workspace_from_lps() * images.grid.mm_from_index;
  const FieldCycle heart = ball(workspace_from_index * Vec3(20, 18, 6));
  const StackBox box = box_around(images.grid, workspace_from_lps(), heart.distance_mm.grid, 0);
  const StackBox wide = box_around(images.grid, workspace_from_lps(), heart.distance_mm.grid, 5);
  EXPECT_TRUE(wide.holds(box));
  EXPECT_FALSE(box.holds(wide));
  const Affine lattice_from_index =
      heart.distance_mm.grid.mm_from_index.inverse() * workspace_from_index;
  int within = 0;
  for (int n = 0; n < 40 * 36 * 12; ++n) {
    const Index3 at{n % 40, n / 40 % 36, n / 1440};
    const Vec3 lattice = lattice_from_index * Vec3(at[0], at[1], at[2]);
    if (lattice.minCoeff() < 0 || lattice.maxCoeff() > 24) continue;
    ++within;
    ASSERT_TRUE(box.holds({at, {1, 1, 1}})) << at[0] << " " << at[1] << " " << at[2];
  }
  // A cube turned against its box fills at least a fifth of it (a cube on its corner: 0.19), less
  // the rounding to whole voxels.
  EXPECT_GT(within, box.size[0] * box.size[1] * box.size[2] / 8);

  const HeartImages direct = cut_images(images, 3, box);
  const HeartImages twice = cut_images(cut_images(images, 3, wide), images.grid, box);
  EXPECT_EQ(direct.images.phases, twice.images.phases);
  EXPECT_EQ(direct.noise, 3);
  EXPECT_EQ(twice.noise, 3);
  EXPECT_EQ(direct.images.grid, twice.images.grid) << "to the last bit: packages keep it";
  EXPECT_EQ(direct.images.phases[2][0],
            images.phases[2][images.grid.offset(box.first[0], box.first[1], box.first[2])]);
  // Beyond the stack there is nothing.
  const Grid far{{4, 4, 4}, Affine(Eigen::Translation3d(900, 0, 0))};
  EXPECT_EQ(box_around(images.grid, workspace_from_lps(), far, 0).size[0] *
                box_around(images.grid, workspace_from_lps(), far, 0).size[1],
            0);
}

TEST(StoredImages, LieWhereTheSourceHadThem) {
  const ImageCycle<float> images = stack();
  const Affine workspace_from_index = workspace_from_lps() * images.grid.mm_from_index;
  const FieldCycle heart = ball(workspace_from_index * Vec3(20, 18, 6));
  HeartImages part = cut_images(
      images, 0, box_around(images.grid, workspace_from_lps(), heart.distance_mm.grid, 0));
  part.images.grid.mm_from_index = workspace_from_lps() * part.images.grid.mm_from_index;
  pack::EncodeOptions fine;
  fine.volume_step = fine.volume_threshold = 0.25;
  const atlas::VolumePayload volume =
      atlas::decode_volume(pack::pack_volume(part.images, 0, heart, fine).entry);
  const ImageCycle<float> found = images_of(volume, images.grid, workspace_from_lps());
  EXPECT_EQ(found.grid.size, images.grid.size);
  ASSERT_EQ(found.phase_count(), 3);
  for (std::size_t p = 0; p < 3; ++p) {
    for (int n = 0; n < 40 * 36 * 12; ++n) {
      const bool inside = part.box.holds({{n % 40, n / 40 % 36, n / 1440}, {1, 1, 1}});
      // Of a range of 800 a 2000th counts as noise; a shift of a voxel would be 7 and more.
      ASSERT_NEAR(found.phases[p][std::size_t(n)], inside ? images.phases[p][std::size_t(n)] : 0, 1)
          << n;
    }
  }
  // On another grid than the source's they keep their own place.
  Grid other = images.grid;
  other.mm_from_index.translation().x() += 0.7;
  const ImageCycle<float> apart = images_of(volume, other, workspace_from_lps());
  EXPECT_EQ(apart.grid.size, volume.size);
  EXPECT_TRUE(apart.grid.mm(3, 2, 1).isApprox(
      images.grid.mm(3 + part.box.first[0], 2 + part.box.first[1], 1 + part.box.first[2]), 1e-9));
  // And without a source.
  EXPECT_EQ(images_of(volume, Grid{}, workspace_from_lps()).grid.size, volume.size);
}

}  // namespace
}  // namespace beatlas::cli
