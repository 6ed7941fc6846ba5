#include <cmath>

#include <gtest/gtest.h>

#include "tests/unit/phantom/scanner_images.h"

namespace beatlas::phantom {
namespace {

TEST(PhantomShift, AVoxelShowsWhatTheSliceMovedThere) {
  PhantomSpec spec = test::of_centres();
  spec.oblique_deg = {0.0, 20.0, 5.0};
  spec.scanner.shift_sigma_mm = 4.0;
  const Phantom phantom(spec);
  const test::PointSignal signal(phantom);
  const Grid grid = spec.imaging_grid();
  const auto images = test::images_of(spec);
  const auto slices = acquisition(spec);
  const Vec3 along_i = grid.mm_from_index.linear().col(0).normalized();
  const Vec3 along_j = grid.mm_from_index.linear().col(1).normalized();
  const auto frame = phantom.frame(phantom.phase_time_s(2));
  int moved = 0;
  test::for_each_index(grid, [&](int i, int j, int k) {
    const Vec3 here = grid.mm(i, j, k);
    const Vec3 from = here - slices[k].shift_i_mm * along_i - slices[k].shift_j_mm * along_j;
    ASSERT_NEAR(images[2][grid.offset(i, j, k)], signal.at(*frame, from), 0.51);
    moved += signal.at(*frame, from) != signal.at(*frame, here);
  });
  EXPECT_GT(moved, 1000);
}

TEST(PhantomShift, IsFoundByComparingWithTheUnshiftedImage) {
  PhantomSpec spec = test::coarse(2.0);
  spec.phases = 2;
  const auto truth = test::images_of(spec)[0];
  spec.scanner.shift_sigma_mm = 2.0;
  const auto image = test::images_of(spec)[0];
  const Grid grid = spec.imaging_grid();
  const auto slices = acquisition(spec);
  const auto at = [&](double i, double j, int k) {
    const int a = static_cast<int>(std::floor(i));
    const int b = static_cast<int>(std::floor(j));
    const double u = i - a;
    const double v = j - b;
    return (1 - v) * ((1 - u) * truth[grid.offset(a, b, k)] + u * truth[grid.offset(a + 1, b, k)]) +
           v * ((1 - u) * truth[grid.offset(a, b + 1, k)] +
                u * truth[grid.offset(a + 1, b + 1, k)]);
  };
  for (int k = 4; k < 16; k += 3) {
    double best = 1e300;
    double best_i = 0;
    double best_j = 0;
    for (double di = -5; di <= 5; di += 0.25) {
      for (double dj = -5; dj <= 5; dj += 0.25) {
        double sum = 0;
        for (int j = 4; j < grid.size[1] - 4; ++j) {
          for (int i = 4; i < grid.size[0] - 4; ++i) {
            const double error = image[grid.offset(i, j, k)] - at(i - di / 2, j - dj / 2, k);
            sum += error * error;
          }
        }
        if (sum < best) {
          best = sum;
          best_i = di;
          best_j = dj;
        }
      }
    }
    // The step of the search, and a tenth of a pixel for interpolation.
    EXPECT_NEAR(best_i, slices[k].shift_i_mm, 0.45) << k;
    EXPECT_NEAR(best_j, slices[k].shift_j_mm, 0.45) << k;
  }
}

TEST(PhantomShift, HasItsDeviationAndLimit) {
  PhantomSpec spec = test::coarse();
  spec.grid.size[2] = 1000;
  spec.scanner.shift_sigma_mm = 2.0;
  spec.scanner.shift_limit_mm = 50.0;
  double squares = 0;
  double cross = 0;
  for (const auto& slice : acquisition(spec)) {
    squares += slice.shift_i_mm * slice.shift_i_mm + slice.shift_j_mm * slice.shift_j_mm;
    cross += slice.shift_i_mm * slice.shift_j_mm;
  }
  EXPECT_NEAR(std::sqrt(squares / 2000), 2.0, 5 * 2.0 / std::sqrt(2 * 2000.0));
  EXPECT_NEAR(cross / 1000, 0.0, 5 * 4.0 / std::sqrt(1000.0));
  spec.scanner.shift_limit_mm = 3.0;
  int cut = 0;
  for (const auto& slice : acquisition(spec)) {
    const double length = std::hypot(slice.shift_i_mm, slice.shift_j_mm);
    EXPECT_LE(length, 3.0 + 1e-12);
    cut += length > 3.0 - 1e-9;
  }
  // exp(-9/8) of a circular normal distribution lie beyond 1.5 sigma.
  EXPECT_NEAR(cut / 1000.0, std::exp(-9.0 / 8.0), 0.08);
}

}  // namespace
}  // namespace beatlas::phantom
