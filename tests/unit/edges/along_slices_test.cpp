/// The place of a surface that runs along the slices, against closed form.
#include "pipeline/edges/along_slices.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/made_images.h"

namespace beatlas::edges::along_slices_tests {
namespace {

constexpr int kSize = 64;
constexpr int kSlices = 20;
constexpr double kSliceMm = 3;
constexpr double kOutside = 40;
constexpr double kMuscle = 340;
constexpr double kBlood = 1000;
constexpr double kFat = 1500;
constexpr double kRadiusMm = 24;
constexpr double kWallMm = 9;

/// A ball of muscle about blood, in voxels of 1 x 1 x 3 mm; `lowest_mm` from the middle of a slice.
/// A layer of fat may lie about it.
struct Ball {
  Grid grid = made::straight_grid({kSize, kSize, kSlices}, {1, 1, kSliceMm});
  std::vector<float> share;
  std::vector<float> image;
  std::vector<std::uint8_t> inside;
  std::vector<std::uint8_t> wall;
  std::vector<std::uint8_t> blood;
  std::vector<float> blood_share;

  Ball(double lowest_mm, double noise, double fat_mm = 0) {
    constexpr int kPlane = 4;
    constexpr int kDeep = 12;
    const Vec3 centre(31.4, 31.7, 3 * kSliceMm + lowest_mm + kRadiusMm);
    std::mt19937 random(7);
    std::normal_distribution<double> normal(0, 1);
    for (std::size_t v = 0; v < grid.count(); ++v) {
      const auto i = static_cast<int>(v % kSize);
      const auto j = static_cast<int>(v / kSize % kSize);
      const auto k = static_cast<int>(v / (kSize * kSize));
      double in = 0;
      double in_blood = 0;
      double in_fat = 0;
      for (int n = 0; n < kPlane * kPlane * kDeep; ++n) {
        const Vec3 x(i + (n % kPlane + 0.5) / kPlane - 0.5,
                     j + (n / kPlane % kPlane + 0.5) / kPlane - 0.5,
                     kSliceMm * (k + (n / (kPlane * kPlane) + 0.5) / kDeep - 0.5));
        const double r = (x - centre).norm();
        in += r < kRadiusMm;
        in_blood += r < kRadiusMm - kWallMm;
        in_fat += r >= kRadiusMm && r < kRadiusMm + fat_mm;
      }
      in /= kPlane * kPlane * kDeep;
      in_blood /= kPlane * kPlane * kDeep;
      in_fat /= kPlane * kPlane * kDeep;
      share.push_back(static_cast<float>(in));
      image.push_back(static_cast<float>(kOutside + (kMuscle - kOutside) * in +
                                         (kBlood - kMuscle) * in_blood +
                                         (kFat - kOutside) * in_fat + noise * normal(random)));
      // Labels leave out what is hardly more than half full, as outlines that were smoothed do.
      inside.push_back(in >= 0.7);
      blood.push_back(in_blood >= 0.5);
      blood_share.push_back(static_cast<float>(in_blood));
      wall.push_back(in >= 0.7 && image.back() < 0.5 * (kMuscle + kBlood));
    }
  }

  [[nodiscard]] BoundaryInput input(double noise) const {
    static const std::vector<std::uint8_t> anything(grid.count(), 1);
    return {.grid = grid,
            .image = image,
            .inside = inside,
            .tells_inner = wall,
            .tells_outer = anything,
            .bare = &blood,
            .contrast = 50,
            .noise = noise};
  }

  /// Of the blood within the wall.
  [[nodiscard]] BoundaryInput cavity(const std::vector<std::uint8_t>& outer) const {
    return {.grid = grid,
            .image = image,
            .inside = blood,
            .tells_inner = blood,
            .tells_outer = outer,
            .contrast = 50,
            .noise = 0};
  }

  /// Mean and largest error [mm] of the surface's height within 12 mm of the pole, where it rises
  /// by at most half a millimetre a millimetre: a column's sum is its height.
  [[nodiscard]] std::pair<double, double> height_error_mm(
      const std::vector<float>& coverage) const {
    double sum = 0;
    double most = 0;
    int count = 0;
    for (int j = 20; j <= 44; ++j) {
      for (int i = 20; i <= 44; ++i) {
        if (std::hypot(i - 31.4, j - 31.7) > 12) continue;
        double off = 0;
        for (int k = 0; k < kSlices / 2; ++k) {
          off += kSliceMm * (coverage[grid.offset(i, j, k)] - share[grid.offset(i, j, k)]);
        }
        sum += off;
        most = std::max(most, std::abs(off));
        ++count;
      }
    }
    return {sum / count, most};
  }
};

TEST(AlongSlices, APoleIsKnownToATenthOfASliceWhereverItLiesInOne) {
  for (const double lowest_mm : {-1.4, -0.7, 0.0, 0.7, 1.4}) {
    const Ball ball(lowest_mm, 0);
    std::vector<float> coverage = find_boundary(ball.input(0)).coverage;
    const auto [mean_before, most_before] = ball.height_error_mm(coverage);
    EXPECT_FALSE(cover_along_slices(ball.input(0), {.inner_level = kMuscle}, coverage).empty());
    const auto [mean, most] = ball.height_error_mm(coverage);
    EXPECT_LT(std::abs(mean), 0.05 * kSliceMm) << lowest_mm;
    EXPECT_LT(most, 0.3 * kSliceMm) << lowest_mm;
    EXPECT_LT(std::abs(mean), 0.5 * std::abs(mean_before)) << lowest_mm;
    EXPECT_LT(most, most_before) << lowest_mm;
  }
}

TEST(AlongSlices, NoiseOfAChannelMovesThePoleByLessThanATenthOfASlice) {
  constexpr double kNoise = 50;  // SNR 20 of blood
  const Ball ball(0.5, kNoise);
  std::vector<float> coverage = find_boundary(ball.input(kNoise)).coverage;
  (void)cover_along_slices(ball.input(kNoise), {.inner_level = kMuscle}, coverage);
  EXPECT_LT(std::abs(ball.height_error_mm(coverage).first), 0.1 * kSliceMm);
}

TEST(AlongSlices, AThinLayerOfFatIsNotTakenForMuscle) {
  for (const double lowest_mm : {-1.4, -0.7, 0.0, 0.7, 1.4}) {
    const Ball ball(lowest_mm, 0, 0.5 * kSliceMm);
    std::vector<float> coverage = find_boundary(ball.input(0)).coverage;
    const auto [mean_before, most_before] = ball.height_error_mm(coverage);
    (void)cover_along_slices(ball.input(0), {.inner_level = kMuscle}, coverage);
    const auto [mean, most] = ball.height_error_mm(coverage);
    EXPECT_LT(std::abs(mean), std::abs(mean_before) + 0.01 * kSliceMm) << lowest_mm;
    EXPECT_LT(most, most_before + 0.01 * kSliceMm) << lowest_mm;
  }
}

TEST(AlongSlices, AFloorOfBloodIsKnownOnlyWhereAWallLiesUnderIt) {
  for (const double lowest_mm : {-1.4, 0.0, 1.4}) {
    const Ball ball(lowest_mm, 0);
    // The mean height error of the cavity's pole, within 6 mm where it is level.
    const auto off_mm = [&](const std::vector<float>& coverage) {
      double sum = 0;
      int count = 0;
      for (int j = 26; j <= 37; ++j) {
        for (int i = 26; i <= 37; ++i, ++count) {
          for (int k = 0; k < kSlices / 2; ++k) {
            const std::size_t v = ball.grid.offset(i, j, k);
            sum += kSliceMm * (coverage[v] - ball.blood_share[v]);
          }
        }
      }
      return sum / count;
    };
    const Sides sides{.inner_level = kBlood, .outer_level = kMuscle, .walls = &ball.inside};
    const std::vector<float> before = find_boundary(ball.cavity(ball.wall)).coverage;
    std::vector<float> coverage = before;
    EXPECT_FALSE(cover_along_slices(ball.cavity(ball.wall), sides, coverage).empty());
    EXPECT_LT(std::abs(off_mm(coverage)), 0.05 * kSliceMm) << lowest_mm;
    EXPECT_LT(std::abs(off_mm(coverage)), std::abs(off_mm(before))) << lowest_mm;
    // Where only what stands around the floor is wall, it is a mouth.
    std::vector<std::uint8_t> ring = ball.wall;
    std::vector<std::size_t> mouth;
    for (int k = 0; k < kSlices / 2; ++k) {
      for (int j = 25; j <= 38; ++j) {
        for (int i = 25; i <= 38; ++i) {
          mouth.push_back(ball.grid.offset(i, j, k));
          ring[mouth.back()] = 0;
        }
      }
    }
    coverage = before;
    (void)cover_along_slices(ball.cavity(ring), sides, coverage);
    for (const std::size_t v : mouth) ASSERT_EQ(coverage[v], before[v]) << lowest_mm;
  }
}

TEST(AlongSlices, WithoutNoiseASlantIsAsSharpAsItsVoxels) {
  const Ball ball(0.3, 0);
  std::vector<float> coverage = find_boundary(ball.input(0)).coverage;
  double square = 0;
  int count = 0;
  for (const Settled& at : cover_along_slices(ball.input(0), {.inner_level = kMuscle}, coverage)) {
    const double off = coverage[at.voxel] - ball.share[at.voxel];
    square += off * off;
    ++count;
  }
  EXPECT_LT(std::sqrt(square / count), 0.045);
}

TEST(AlongSlices, SteepWallsAndWallsWithoutContrastStay) {
  const Ball ball(0.3, 0);
  const std::vector<float> before = find_boundary(ball.input(0)).coverage;
  std::vector<float> coverage = before;
  (void)cover_along_slices(ball.input(0), {.inner_level = kMuscle}, coverage);
  const int equator = 3 + static_cast<int>(kRadiusMm / kSliceMm);
  for (std::size_t v = ball.grid.offset(0, 0, equator); v < ball.grid.offset(0, 0, equator + 1);
       ++v) {
    EXPECT_EQ(coverage[v], before[v]);
  }
  BoundaryInput flat = ball.input(0);
  flat.contrast = kMuscle - kOutside + 1;
  coverage = before;
  EXPECT_TRUE(cover_along_slices(flat, {.inner_level = kMuscle}, coverage).empty());
  EXPECT_EQ(coverage, before);
}

}  // namespace
}  // namespace beatlas::edges::along_slices_tests
