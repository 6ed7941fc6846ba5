#include <algorithm>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "runtime/viewer/heart_frame.h"
#include "runtime/viewer/heart_mask.h"
#include "runtime/viewer/image_cut.h"
#include "runtime/viewer/surface_motion.h"
#include "tests/viewer/ellipsoid.h"

namespace beatlas::viewer {
namespace {

using test::BeatingEllipsoid;

struct Made {
  test::TemporaryFolder folder;
  BeatingEllipsoid heart;
  std::shared_ptr<const atlas::Atlas> atlas = test::ellipsoid_atlas(folder, heart, 10, 4);
};

TEST(SurfaceMotion, GoesThroughThePackagedPhasesAndRepeats) {
  const Made made;
  const auto surface = made.atlas->surface(Structure::Heart);
  const SurfaceMotion motion(surface);
  std::vector<Vec3f> found(motion.vertex_count());
  for (int phase = 0; phase < 10; ++phase) {
    for (const double beats : {phase / 10.0, phase / 10.0 + 3, phase / 10.0 - 2}) {
      motion.positions_at(beats, found);
      double worst = 0;
      for (std::size_t v = 0; v < found.size(); ++v) {
        const Vec3f& stored = surface->positions[static_cast<std::size_t>(phase)][v];
        worst = std::max(worst, static_cast<double>((found[v] - stored).norm()));
      }
      EXPECT_LT(worst, 2e-4) << beats;  // floats at 200 mm
    }
  }
}

// Ten phases of a cosine of 3 mm: a cubic spline is within 0.01 mm half-way between them, a
// straight line is 0.14 mm off.
TEST(SurfaceMotion, IsTheClosedFormBetweenThePhases) {
  const Made made;
  const SurfaceMotion motion(made.atlas->surface(Structure::Heart));
  std::vector<Vec3f> found(motion.vertex_count());
  for (const double beats : {0.05, 0.17, 0.333, 0.5, 0.77, 0.95}) {
    motion.positions_at(beats, found);
    double worst = 0;
    for (const Vec3f& x : found) {
      const Vec3 from_middle = x.cast<double>() - made.heart.centre_mm;
      const double r = made.heart.radius_along(beats, from_middle.normalized());
      worst = std::max(worst, std::abs(from_middle.norm() - r));
    }
    EXPECT_LT(worst, 0.02) << beats;  // 0.01 mm of it is the package's own step
  }
}

TEST(SurfaceMotion, NormalsAreTheClosedForms) {
  const Made made;
  const SurfaceMotion motion(made.atlas->surface(Structure::Heart));
  std::vector<Vec3f> positions(motion.vertex_count());
  std::vector<Vec3f> normals(motion.vertex_count());
  motion.positions_at(0.37, positions);
  motion.normals_of(positions, normals);
  const Eigen::Matrix3d inverse = made.heart.shape(0.37).inverse();
  double worst = 0;
  for (std::size_t v = 0; v < normals.size(); ++v) {
    const Vec3 exact =
        (inverse * (positions[v].cast<double>() - made.heart.centre_mm)).normalized();
    worst = std::max(worst, std::acos(std::min(1.0, exact.dot(normals[v].cast<double>()))));
  }
  EXPECT_LT(worst, 0.03);  // edges are 3 mm, radii 30 mm
}

TEST(SurfaceMotion, ASurfaceWithoutPhasesIsRefused) {
  EXPECT_THROW(SurfaceMotion(nullptr), Error);
  EXPECT_THROW(SurfaceMotion(std::make_shared<const atlas::SurfacePayload>()), Error);
}

TEST(CutSurface, IsTheSectionAndClosed) {
  const Made made;
  const SurfaceMotion motion(made.atlas->surface(Structure::Heart));
  std::vector<Vec3f> positions(motion.vertex_count());
  motion.positions_at(0.2, positions);
  const Vec3 normal = Vec3(0.3, -0.5, 0.8).normalized();
  const auto segments =
      cut_surface(motion.surface().triangles, positions, made.heart.centre_mm, normal);
  ASSERT_GT(segments.size(), 50U);
  Vec3 sum = Vec3::Zero();
  for (const CutSegment& segment : segments) {
    for (const Vec3f& end : {segment.from_mm, segment.to_mm}) {
      const Vec3 from_middle = end.cast<double>() - made.heart.centre_mm;
      EXPECT_LT(std::abs(normal.dot(from_middle)), 1e-3);
      // Chords of triangles of 3 mm lie up to 0.05 mm inside.
      EXPECT_NEAR(from_middle.norm(), made.heart.radius_along(0.2, from_middle.normalized()), 0.12);
    }
    sum += (segment.to_mm - segment.from_mm).cast<double>();
  }
  EXPECT_LT(sum.norm(), 1e-3);
  EXPECT_TRUE(cut_surface(motion.surface().triangles, positions,
                          made.heart.centre_mm + 100 * normal, normal)
                  .empty());
}

// Trilinear interpolation gives a linear function back, whatever the plane.
TEST(ImageCut, ALinearImageComesBack) {
  atlas::VolumePayload volume;
  volume.size = {20, 16, 12};
  volume.phases = 1;
  volume.workspace_from_index = Eigen::Translation3d(40, 50, 60) *
                                Eigen::AngleAxisd(0.4, Vec3(1, 2, -1).normalized()) *
                                Eigen::Scaling(1.5, 2.0, 3.0);
  std::vector<std::uint8_t> samples(volume.sample_count());
  std::size_t n = 0;
  for (int z = 0; z < 12; ++z) {
    for (int y = 0; y < 16; ++y) {
      for (int x = 0; x < 20; ++x) samples[n++] = static_cast<std::uint8_t>(5 * x + 4 * y + 6 * z);
    }
  }
  const Vec3 middle = volume.workspace_from_index * Vec3(9.5, 7.5, 5.5);
  const PlaneGrid grid = cut_grid(volume, middle, Vec3(0.2, 0.5, 0.7), 0.7);
  ASSERT_GT(grid.pixels(), 1000U);
  std::vector<std::uint8_t> grey_alpha(2 * grid.pixels());
  sample_cut(volume, samples, grid, grey_alpha);
  const Affine index_from_workspace = volume.workspace_from_index.inverse();
  int inside = 0;
  for (int j = 0; j < grid.height; ++j) {
    for (int i = 0; i < grid.width; ++i) {
      const Vec3 index = index_from_workspace *
                         Vec3(grid.corner_mm + (i + 0.5) * grid.x_mm + (j + 0.5) * grid.y_mm);
      const std::size_t at = 2 * static_cast<std::size_t>(j * grid.width + i);
      const bool in =
          (index.array() >= 0).all() && index.x() <= 19 && index.y() <= 15 && index.z() <= 11;
      if (!in) continue;
      ++inside;
      EXPECT_EQ(grey_alpha[at + 1], 255);
      EXPECT_NEAR(grey_alpha[at], 5 * index.x() + 4 * index.y() + 6 * index.z(), 0.5 + 1e-6);
    }
  }
  EXPECT_GT(inside, 500);
  EXPECT_EQ(cut_grid(volume, middle + Vec3(500, 0, 0), Vec3::UnitX(), 0.7).pixels(), 0U);
}

// Where a package tells the long axis, views follow that, and not the longest way through the LV.
TEST(HeartFrame, LiesAsTheMapOfTheWallSays) {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "sample.beatlas";
  pack::write_package(file, test::sample_content(6, 36, 2, 4));
  const atlas::Atlas sample =
      atlas::Atlas::open(file, atlas::everything_in(atlas::Atlas::open(file, {}).manifest()));
  ASSERT_TRUE(sample.surface_map(Structure::LvBlood));
  EXPECT_LT(heart_frame(sample).apexward.dot(Vec3::UnitZ()), -0.99);  // the map's base is above
}

TEST(HeartFrame, ViewsAreRightHandedAndCutsFaceTheirViewer) {
  const Made made;
  atlas::Needs needs = atlas::everything_in(made.atlas->manifest());
  needs.maps.clear();
  const HeartFrame frame =
      heart_frame(atlas::Atlas::open(made.folder.path() / "ellipsoid.beatlas", needs));
  EXPECT_LT((frame.centre_mm - made.heart.centre_mm).norm(), 0.1);
  // The longest half axis is the first.
  EXPECT_GT(std::abs(frame.apexward.dot(made.heart.axes.col(0))), 0.999);
  EXPECT_GT(frame.apexward.dot(frame.lps(1, -1, -1)), 0);
  EXPECT_LT(std::abs(frame.apexward.dot(frame.to_right)), 1e-9);
  for (const std::string_view name : kViews) {
    const CameraPose pose = standard_view(frame, name);
    EXPECT_LT(std::abs(pose.up.dot(pose.towards_viewer)), 1e-9) << name;
    EXPECT_NEAR(pose.up.norm(), 1, 1e-9) << name;
  }
  const CameraPose four = standard_view(frame, "four-chamber");
  const Vec3 right_of_picture = four.up.cross(four.towards_viewer);
  EXPECT_LT(right_of_picture.dot(frame.to_right), -0.999);  // the right ventricle is on the left
  EXPECT_GT(four.up.dot(frame.apexward), 0.999);
  EXPECT_GT(standard_cut(frame, "four-chamber", 0).normal.dot(four.towards_viewer), 0.999);
  const CutPlane moved = standard_cut(frame, "axial", 7);
  EXPECT_NEAR((moved.point_mm - frame.centre_mm).dot(moved.normal), 7, 1e-9);
}

// The voxels that are looked at again each moment are enough.
TEST(HeartMask, IsTheHeartsShareAtAnyMoment) {
  const Made made;
  const auto volume = made.atlas->volume();
  const auto field = std::make_shared<const field::FieldQuery>(
      made.atlas->field(Structure::Heart), made.atlas->manifest().rr_interval_s);
  // The images' own voxels, and slices that lie far apart: what is well outside is not seen.
  for (const double apart : {1.0, 4.5}) {
    Affine grid = volume->workspace_from_index;
    grid.linear().col(2) *= apart;
    const std::array<int, 3> size{volume->size[0], volume->size[1],
                                  static_cast<int>(volume->size[2] / apart)};
    const double half_mm = std::clamp(0.5 * grid.linear().colwise().norm().maxCoeff(), 0.75, 2.0);
    HeartMask mask(grid, size, field);
    for (const double beats : {0.31, 0.0, 2.77}) {
      const std::vector<std::uint8_t>& found = mask.at(beats);
      std::size_t at = 0;
      std::size_t between = 0;
      std::size_t outside = 0;
      for (int z = 0; z < size[2]; ++z) {
        for (int y = 0; y < size[1]; ++y) {
          for (int x = 0; x < size[0]; ++x, ++at) {
            const double distance =
                field->sample(grid * Vec3(x, y, z), beats * field->rr_interval_s()).distance_mm;
            const double share = std::clamp(0.5 - (distance + 0.5) / (2 * half_mm), 0.0, 1.0);
            // Between moments a cubic runs: 2 % of the fall, 0.1 mm.
            EXPECT_NEAR(found[at], 255 * share, 0.02 * 255);
            between += share > 0 && share < 1 ? 1 : 0;
            outside += distance > 4 && found[at] == 0 ? 1 : 0;
          }
        }
      }
      EXPECT_GT(between, 20U) << beats;
      EXPECT_GT(outside, 20U) << beats;
    }
  }
}

}  // namespace
}  // namespace beatlas::viewer
