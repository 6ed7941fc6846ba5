#include "pipeline/identify/elastogram.h"

#include <cmath>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "tests/unit/palpation/sample_wall.h"

namespace beatlas::identify {
namespace {

using palpation::LvWall;
using palpation::test::kRadiusMm;
using palpation::test::SampleWall;

/// Voxels of 2 x 2 x 3 mm about a ball of 25 mm with a wall of 4 or 10 mm; the workspace lies
/// turned and beside the patient's frame.
struct MadeElastogram {
  Grid grid;
  std::vector<float> image;
  Affine workspace_from_lps = Affine::Identity();

  template <class Kpa>
  explicit MadeElastogram(const Kpa& kpa_at) {
    workspace_from_lps.linear() =
        Eigen::AngleAxisd(0.5, Vec3(1, 2, 0.5).normalized()).toRotationMatrix();
    workspace_from_lps.translation() = Vec3(10, -20, 5);
    grid.size = {56, 56, 40};
    const Vec3 middle = workspace_from_lps.inverse() * Vec3::Zero();
    grid.mm_from_index = Affine::Identity();
    grid.mm_from_index.linear() = Vec3(2, 2, 3).asDiagonal();
    grid.mm_from_index.translation() = middle - Vec3(55, 55, 58.5);
    image.resize(grid.count());
    for (int k = 0; k < grid.size[2]; ++k) {
      for (int j = 0; j < grid.size[1]; ++j) {
        for (int i = 0; i < grid.size[0]; ++i) {
          const Vec3 x = workspace_from_lps * (grid.mm_from_index * Vec3(i, j, k));
          image[grid.offset(i, j, k)] = static_cast<float>(kpa_at(x));
        }
      }
    }
  }
  [[nodiscard]] std::vector<float> on(const LvWall& wall,
                                      const ElastogramOptions& options = {}) const {
    return elastogram_of_wall(wall, workspace_from_lps, grid, image, options);
  }
};

std::string refusal(const std::function<void()>& body) {
  try {
    body();
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

// A modulus that is linear in space: trilinear values are exact, and their mean along a straight
// way is the value in its middle.
TEST(Elastogram, OfALinearModulusIsThatOfTheMiddleOfTheWall) {
  const SampleWall sample;
  const LvWall wall = sample.wall();
  const auto kpa = [](const Vec3& x) { return 40 + 0.3 * x.x() - 0.2 * x.y() + 0.1 * x.z(); };
  const MadeElastogram made(kpa);
  const std::vector<float> found = made.on(wall);
  const std::vector<float> shear = made.on(wall, {.modulus = Modulus::Shear, .kpa_per_unit = 0.1});
  int walls = 0;
  for (std::uint32_t v = 0; v < wall.vertex_count(); ++v) {
    const double thick = static_cast<double>(wall.wall_mm()[v]);
    if (!(thick > 0)) {
      EXPECT_EQ(found[v], 0) << v;
      continue;
    }
    ++walls;
    EXPECT_NEAR(found[v], kpa(wall.mm(v) + 0.5 * thick * wall.outward(v)), 1e-3) << v;
    EXPECT_NEAR(shear[v], 0.3 * static_cast<double>(found[v]), 1e-4) << v;
  }
  EXPECT_GT(walls, 900);
}

TEST(Elastogram, WhatWasNotMeasuredIsLeftOut) {
  const SampleWall sample;
  const LvWall wall = sample.wall();
  // Measured on one side alone, in the wall and nowhere else.
  const std::vector<float> found =
      MadeElastogram([](const Vec3& x) {
        const double r = x.norm();
        return x.y() > 0 && r > kRadiusMm && r < kRadiusMm + 10 ? 12 : 0;
      }).on(wall);
  int measured = 0;
  for (std::uint32_t v = 0; v < wall.vertex_count(); ++v) {
    const double y = wall.mm(v).y();
    if (y < -4) {
      EXPECT_EQ(found[v], 0) << v;
    }
    if (y > 4 && wall.wall_mm()[v] > 5) {
      EXPECT_NEAR(found[v], 12, 1e-4) << v;
      ++measured;
    }
  }
  EXPECT_GT(measured, 200);
}

TEST(Elastogram, ImagesThatMeanNothingAreRefused) {
  const SampleWall sample;
  const LvWall wall = sample.wall();
  EXPECT_NE(refusal([&] {
              (void)MadeElastogram([](const Vec3&) { return 0; }).on(wall);
            }).find("is it an image of this heart"),
            std::string::npos);
  EXPECT_NE(refusal([&] {
              (void)MadeElastogram([](const Vec3&) { return 12000; }).on(wall);
            }).find("--unit kpa or pa"),
            std::string::npos);
  EXPECT_EQ(
      refusal([&] {
        (void)MadeElastogram([](const Vec3&) { return 12000; }).on(wall, {.kpa_per_unit = 1e-3});
      }),
      "accepted");
}

}  // namespace
}  // namespace beatlas::identify
