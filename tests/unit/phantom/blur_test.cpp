#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "pipeline/core/box_share.h"
#include "pipeline/phantom/share.h"
#include "tests/unit/phantom/scanner_images.h"

namespace beatlas::phantom {
namespace {

/// The box's share convolved along the normal by summing on a fine grid.
double integrated(const Vec3& half, double sigma, double distance, const Vec3& outward) {
  constexpr int kSteps = 2000;
  constexpr double kReach = 6.0;
  double sum = 0.0;
  double weights = 0.0;
  for (int n = 0; n < kSteps; ++n) {
    const double u = kReach * ((2.0 * n + 1.0) / kSteps - 1.0);
    const double weight = std::exp(-0.5 * u * u);
    sum += weight * box_share(half, distance + sigma * u, outward);
    weights += weight;
  }
  return sum / weights;
}

TEST(PhantomBlur, OfABoxEqualsItsConvolution) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  double worst = 0.0;
  for (int n = 0; n < 400; ++n) {
    const Vec3 half(0.5, 0.7, 1.5);
    const Vec3 sigma(0.05 + uniform(random), 0.05 + uniform(random), 0.05 + uniform(random));
    Vec3 outward(normal(random), normal(random), normal(random));
    if (n % 4 == 1) outward[n % 3] = 0.0;
    if (n % 4 == 2) outward = Vec3::Unit(n % 3);
    outward.normalize();
    const double d = 3.0 * normal(random);
    const double expected = integrated(half, outward.cwiseProduct(sigma).norm(), d, outward);
    const double error = std::abs(blurred_box_share(half, sigma, d, outward) - expected);
    worst = std::max(worst, error);
  }
  EXPECT_LT(worst, 5e-4);  // as share.h promises
  EXPECT_GT(worst, 1e-7) << "the reference must not be the same code";
}

TEST(PhantomBlur, OfNothingIsSharpAndOfAPointIsTheNormalDistribution) {
  const Vec3 half(0.5, 0.5, 1.5);
  const Vec3 outward = Vec3(1, 2, -1).normalized();
  EXPECT_EQ(blurred_box_share(half, Vec3::Zero(), 0.3, outward), box_share(half, 0.3, outward));
  for (double d : {-1.0, 0.0, 0.4, 1.9}) {
    EXPECT_NEAR(blurred_box_share(Vec3::Zero(), Vec3::Constant(0.5), d, outward),
                0.5 * std::erfc(d / 0.5 / std::sqrt(2.0)), 1e-12);
  }
  EXPECT_EQ(blurred_box_share(half, Vec3::Constant(0.5), 5.0, outward), 0.0);
  EXPECT_EQ(blurred_box_share(half, Vec3::Constant(0.5), -5.0, outward), 1.0);
}

/// Voxels within reach of the heart's surface.
std::vector<Index3> voxels_near_heart(const Phantom& phantom, double t, double reach_mm,
                                      int count) {
  const Grid grid = phantom.spec().imaging_grid();
  const auto frame = phantom.frame(t);
  std::mt19937 random(3);
  std::vector<Index3> out;
  while (static_cast<int>(out.size()) < count) {
    const Index3 at{static_cast<int>(random() % static_cast<unsigned>(grid.size[0])),
                    static_cast<int>(random() % static_cast<unsigned>(grid.size[1])),
                    static_cast<int>(random() % static_cast<unsigned>(grid.size[2]))};
    double nearest = 1e300;
    for (const MovingBody& body : kMovingBodies) {
      nearest =
          std::min(nearest, std::abs(frame->distance_mm(body.part, grid.mm(at[0], at[1], at[2]))));
    }
    if (nearest < reach_mm) out.push_back(at);
  }
  return out;
}

TEST(PhantomBlur, AVoxelIsTheMeanOverItsBlurredBox) {
  PhantomSpec spec = test::coarse();
  spec.grid = on_matrix(preset("small").grid, {120, 120, 44}, {1.4, 1.4, 3.0});
  spec.phases = 3;
  spec.oblique_deg = {4.0, 0.0, 11.0};
  spec.scanner.in_plane_sigma_mm = 0.9;
  spec.scanner.slice_sigma_mm = 0.6;
  spec.scanner.slice_thickness_mm = 4.0;
  const Phantom phantom(spec);
  const test::PointSignal signal(phantom);
  const Grid grid = spec.imaging_grid();
  const double t = phantom.phase_time_s(1);
  const auto frame = phantom.frame(t);
  const auto images = test::images_of(spec);
  std::mt19937 random(8);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  const Vec3 spacing = grid.spacing_mm();
  double squares = 0.0;
  double mean = 0.0;
  constexpr int kVoxels = 150;
  constexpr int kPoints = 4000;
  for (const Index3& at : voxels_near_heart(phantom, t, 3.5, kVoxels)) {
    double sum = 0.0;
    for (int n = 0; n < kPoints; ++n) {
      const Vec3 mm(uniform(random) * spacing.x() + 0.9 * normal(random),
                    uniform(random) * spacing.y() + 0.9 * normal(random),
                    uniform(random) * 4.0 + 0.6 * normal(random));
      const Vec3 index = mm.cwiseQuotient(spacing);
      sum += signal.at(*frame, grid.mm(at[0] + index[0], at[1] + index[1], at[2] + index[2]));
    }
    const double error = images[1][grid.offset(at[0], at[1], at[2])] - sum / kPoints;
    EXPECT_LT(std::abs(error), 125.0);  // creases: one plane stands for two faces
    squares += error * error;
    mean += error;
  }
  // 4000 points tell a share to 1/126 of the contrast; flat pieces of 3 mm are off by 0.02 mm, and
  // every tenth of these voxels sees a crease through its blur.
  EXPECT_LT(std::sqrt(squares / kVoxels), 20.0);
  EXPECT_LT(std::abs(mean / kVoxels), 3.0);
}

TEST(PhantomBlur, SupersampledVoxelsAreTheMeanOf64Points) {
  PhantomSpec spec = test::coarse();
  spec.scanner.partial_volume = PartialVolume::Supersampled;
  spec.phases = 2;
  const Phantom phantom(spec);
  const test::PointSignal signal(phantom);
  const Grid grid = spec.imaging_grid();
  const double t = phantom.phase_time_s(1);
  const auto images = test::images_of(spec);
  const auto frame = phantom.frame(t);
  const double thickness = spec.scanner.slice_thickness_mm / grid.spacing_mm().z();
  int wrong = 0;
  constexpr int kVoxels = 300;
  for (const Index3& at : voxels_near_heart(phantom, t, 4.0, kVoxels)) {
    double sum = 0.0;
    for (int k = 0; k < 4; ++k) {
      for (int j = 0; j < 4; ++j) {
        for (int i = 0; i < 4; ++i) {
          sum += signal.at(*frame, grid.mm(at[0] + 0.25 * i - 0.375, at[1] + 0.25 * j - 0.375,
                                           at[2] + thickness * (0.25 * k - 0.375)));
        }
      }
    }
    // Rounding; shares are kept as float. Shares are mixed, so a voxel in which the thorax's own
    // border meets the heart may be off: none is, as the heart touches nothing.
    wrong += std::abs(images[1][grid.offset(at[0], at[1], at[2])] - sum / 64.0) > 0.51;
  }
  EXPECT_EQ(wrong, 0);
}

TEST(PhantomBlur, WithoutPartialVolumeAVoxelIsItsCentre) {
  const PhantomSpec spec = test::of_centres();
  const Phantom phantom(spec);
  const test::PointSignal signal(phantom);
  const Grid grid = spec.imaging_grid();
  const auto images = test::images_of(spec);
  for (int p : {0, 2}) {
    const auto frame = phantom.frame(phantom.phase_time_s(p));
    test::for_each_index(grid, [&](int i, int j, int k) {
      ASSERT_NEAR(images[p][grid.offset(i, j, k)], signal.at(*frame, grid.mm(i, j, k)), 0.51);
    });
  }
}

}  // namespace
}  // namespace beatlas::phantom
