/// The RV's pool under fat as bright as blood, in thick slices whose outlines are known.
#include "pipeline/segment/rv_pools.h"

#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "tests/unit/segment/made_images.h"

namespace beatlas::segment {
namespace {

constexpr float kBlood = 400;
constexpr float kMuscle = 120;
constexpr float kLung = 20;
constexpr int kSlices = 9;  ///< base towards larger k
constexpr int kPhases = 10;
constexpr double kPixelMm = 1.5;
constexpr double kSliceMm = 9;

/// An LV, an RV of a 3 mm wall around it, and over both fat as bright as blood.
struct Made {
  ImageCycle<float> images;
  ImageCycle<std::uint8_t> rv;  ///< not 0: its blood
  Chambers chambers;
};

double squeeze(int phase) { return 0.15 * (1 - std::cos(2 * M_PI * phase / kPhases)); }

Made made_heart() {
  Made out;
  const Grid grid = made::straight_grid({100, 90, kSlices}, {kPixelMm, kPixelMm, kSliceMm});
  out.images = made::constant_images(grid, kPhases, kLung);
  out.rv.grid = grid;
  out.rv.phases.assign(kPhases, std::vector<std::uint8_t>(grid.count(), 0));
  const cv::Point2d centre(58, 44);
  Chambers& chambers = out.chambers;
  chambers.base_step = 1;
  chambers.wall_mm = 9;
  chambers.levels = {kBlood, kBlood, kMuscle, 0.5 * (kBlood + kMuscle), 0.5 * kMuscle};
  const auto width = [](int k) { return std::sqrt(1 - std::pow((8.0 - k) / 9, 2)); };
  for (int k = 0; k < kSlices; ++k) {
    LvSlice slice{k, centre, {}};
    for (int p = 0; p < kPhases; ++p) {
      const double endo = 24 * width(k) * (1 - squeeze(p));
      cv::Mat image = slice_of(grid, out.images.phases[static_cast<std::size_t>(p)], k);
      cv::Mat truth = slice_of(grid, out.rv.phases[static_cast<std::size_t>(p)], k);
      for (int j = 0; j < image.rows; ++j) {
        for (int i = 0; i < image.cols; ++i) {
          const double x = kPixelMm * (i - centre.x);
          const double y = kPixelMm * (j - centre.y);
          const double r = std::hypot(x, y);
          const double a = 36 * width(k) * (1 - squeeze(p));
          const double b = 42 * width(k) * (1 - 0.3 * squeeze(p));
          const double beyond_rv = (std::hypot((x + 20 * width(k)) / a, y / b) - 1) * a;
          float& value = image.at<float>(j, i);
          if (std::min(r - endo - 9, beyond_rv - 3) < 9) value = kBlood;  // fat
          if (r < endo + 9 || beyond_rv < 3) value = kMuscle;
          if (r < endo || (beyond_rv < 0 && r >= endo + 9)) value = kBlood;
          truth.at<std::uint8_t>(j, i) = beyond_rv < 0 && r >= endo + 9 ? 1 : 0;
        }
      }
      cv::GaussianBlur(image, image, {0, 0}, 0.6);
      slice.rings.push_back(trace_ring(image, {kPixelMm, kPixelMm}, centre, chambers.levels));
    }
    chambers.lv.push_back(slice);
  }
  made::add_noise(out.images, 16, 5);
  return out;
}

double dice(const cv::Mat& a, const cv::Mat& b) {
  return 2.0 * cv::countNonZero(a & b) / (cv::countNonZero(a) + cv::countNonZero(b));
}

TEST(RvPools, end_at_the_wall_that_fat_as_bright_as_blood_lies_on) {
  Made made = made_heart();
  const TemporalStats stats = temporal_stats(made.images);
  Setting setting{made.images, stats, {}, {kPixelMm, kPixelMm}, kSliceMm};
  for (const std::vector<float>& phase : made.images.phases) {
    setting.smooth.push_back(smooth_in_plane(made.images.grid, phase, 0.7 * kPixelMm));
  }
  made.chambers.rv = rv_at_end_diastole(setting, made.chambers);
  for (int k = 2; k < kSlices; ++k) {
    const cv::Mat& rv = made.chambers.rv[static_cast<std::size_t>(k)];
    ASSERT_FALSE(rv.empty()) << k;
    EXPECT_GT(dice(rv, slice_of(made.images.grid, made.rv.phases[0], k) != 0), 0.85) << k;
  }

  const auto beat = rv_through_the_beat(made.images, made.chambers);
  for (std::size_t p = 0; p < beat.size(); ++p) {
    for (int k = 2; k < 6; ++k) {
      const cv::Mat& rv = beat[p][static_cast<std::size_t>(k)];
      ASSERT_FALSE(rv.empty()) << p << " " << k;
      EXPECT_GT(dice(rv, slice_of(made.images.grid, made.rv.phases[p], k) != 0), 0.8)
          << p << " " << k;
    }
    // Nearer to the base systole shows atria.
    EXPECT_EQ(beat[p][kSlices - 1].empty(), p != 0) << p;
  }
}

}  // namespace
}  // namespace beatlas::segment
