#include "pipeline/report/overlay.h"

#include <array>
#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "runtime/atlas/structure_colours.h"
#include "runtime/base/error.h"

namespace beatlas::report {
namespace {

constexpr Index3 kSize{40, 30, 3};
constexpr double kRadiusVoxels = 6;

/// A disc of coverage in the middle slice of a coverage part that starts at voxel (10, 6, 1).
struct Case {
  Cine cine;
  Segmentation segmentation;

  Case() {
    Grid grid{kSize, Affine::Identity()};
    grid.mm_from_index.linear() = Vec3(2, 2, 8).asDiagonal();
    cine.images.grid = grid;
    cine.images.phases.assign(2, std::vector<float>(grid.count(), 50.0F));
    for (std::size_t at = 0; at < grid.count(); at += 3) cine.images.phases[0][at] = 150.0F;
    cine.rr_interval_s = 0.8;
    cine.frame_times_s = {0, 0.4};
    segmentation.labels = {grid, {2, std::vector<std::uint8_t>(grid.count(), 0)}};
    segmentation.coverage.first = {10, 6, 1};
    segmentation.coverage.grid = grid.part({10, 6, 1}, {20, 20, 1});
    std::vector<float> disc(segmentation.coverage.grid.count(), 0.0F);
    for (int j = 0; j < 20; ++j) {
      for (int i = 0; i < 20; ++i) {
        const double inside = kRadiusVoxels - std::hypot(i - 10.0, j - 10.0);
        disc[segmentation.coverage.grid.offset(i, j, 0)] =
            static_cast<float>(std::clamp(0.5 + inside, 0.0, 1.0));
      }
    }
    segmentation.coverage.phases[Structure::LvBlood] = {disc, disc};
    segmentation.end_diastole = 0;
    segmentation.end_systole = 1;
  }
};

cv::Mat decode(const std::vector<std::byte>& png) {
  return cv::imdecode(
      cv::Mat(1, static_cast<int>(png.size()), CV_8U, const_cast<std::byte*>(png.data())),
      cv::IMREAD_COLOR);
}

std::vector<cv::Point> pixels_of(const cv::Mat& picture, Structure structure,
                                 const cv::Rect& part) {
  const Colour colour = structure_colour(structure);
  std::vector<cv::Point> found;
  for (int y = part.y; y < part.y + part.height; ++y) {
    for (int x = part.x; x < part.x + part.width; ++x) {
      const auto bgr = picture.at<cv::Vec3b>(y, x);
      if (bgr[2] == colour[0] && bgr[1] == colour[1] && bgr[0] == colour[2]) {
        found.emplace_back(x, y);
      }
    }
  }
  return found;
}

TEST(Overlay, DrawsTheContourWhereCoverageIsAHalf) {
  const Case c;
  OverlayOptions options;
  options.margin_mm = 10;
  options.tile_px = 240;
  const cv::Mat picture = decode(overlay_png(c.cine, c.segmentation, options));
  ASSERT_FALSE(picture.empty());
  // Below the legend. Radius 6 voxels of 2 mm; the crop is 11 or 13 voxels of heart and 5 of margin
  // on either side, so one voxel is tile_px / crop pixels.
  const auto found =
      pixels_of(picture, Structure::LvBlood, {0, 20, picture.cols, picture.rows - 20});
  ASSERT_GT(found.size(), 100U);
  // The contours of ED and ES are two circles: split them at the middle of their extent.
  const auto [left, right] =
      std::minmax_element(found.begin(), found.end(), [](auto a, auto b) { return a.x < b.x; });
  const double middle = 0.5 * (left->x + right->x);
  cv::Point2d centre(0, 0);
  double count = 0;
  for (const cv::Point& pixel : found) {
    if (pixel.x > middle) continue;
    centre += cv::Point2d(pixel);
    ++count;
  }
  centre *= 1 / count;
  double nearest = 1e9;
  double farthest = 0;
  for (const cv::Point& pixel : found) {
    if (pixel.x > middle) continue;
    const double radius = std::hypot(pixel.x - centre.x, pixel.y - centre.y);
    nearest = std::min(nearest, radius);
    farthest = std::max(farthest, radius);
  }
  const double crop_voxels = 13 + 2 * 5;
  const double radius_px = kRadiusVoxels * options.tile_px / crop_voxels;
  // The contour runs through the outermost pixels inside: up to 1.5 pixels of discretisation.
  EXPECT_NEAR(nearest, radius_px, 3.0);
  EXPECT_NEAR(farthest, radius_px, 3.0);
}

TEST(Overlay, RepeatsToTheByte) {
  const Case c;
  EXPECT_EQ(overlay_png(c.cine, c.segmentation), overlay_png(c.cine, c.segmentation));
}

TEST(Overlay, RefusesASegmentationOfOtherPhases) {
  Case c;
  c.segmentation.coverage.phases[Structure::LvBlood].pop_back();
  EXPECT_THROW((void)overlay_png(c.cine, c.segmentation), Error);
}

TEST(Overlay, RefusesCoverageThatLeavesTheGrid) {
  Case c;
  c.segmentation.coverage.first = {30, 6, 1};
  EXPECT_THROW((void)overlay_png(c.cine, c.segmentation), Error);
}

TEST(LeakPicture, RingsThePlaceInItsSliceWithTheContourAndWithout) {
  const Case c;
  LeakAlarm alarm;
  alarm.kind = LeakKind::NoEdge;
  alarm.structure = Structure::LvBlood;
  alarm.phase = 1;
  alarm.lps_mm = c.cine.grid().mm(25, 16, 1);
  const cv::Mat picture = decode(leak_png(c.cine, c.segmentation, alarm, {10, 240}));
  ASSERT_FALSE(picture.empty());
  // The ring's middle, on either side; its colour mixes with the image at its rim.
  std::array<cv::Point2d, 2> middle{};
  std::array<double, 2> count{};
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      const auto bgr = picture.at<cv::Vec3b>(y, x);
      if (bgr[0] < 200 || bgr[2] < 200 || bgr[1] > 120) continue;
      const std::size_t side = x < 242 ? 0 : 1;
      middle[side] += cv::Point2d(x, y);
      ++count[side];
    }
  }
  ASSERT_GT(count[0], 20);
  ASSERT_GT(count[1], 20);
  const cv::Point2d left = middle[0] / count[0];
  const cv::Point2d right = middle[1] / count[1];
  EXPECT_NEAR(right.x - left.x, 244, 1);
  EXPECT_NEAR(right.y, left.y, 1);
  // The contour stands on the left only, its centre five voxels from the ring's.
  const auto drawn = pixels_of(picture, Structure::LvBlood, {0, 20, 240, picture.rows - 20});
  ASSERT_GT(drawn.size(), 50U);
  EXPECT_TRUE(
      pixels_of(picture, Structure::LvBlood, {244, 20, picture.cols - 244, picture.rows - 20})
          .empty());
  double x = 0;
  for (const cv::Point& pixel : drawn) x += pixel.x / static_cast<double>(drawn.size());
  const double px_per_voxel = 240.0 / 23;
  EXPECT_NEAR(left.x - x, 5 * px_per_voxel, 6);
}

TEST(LeakPicture, OfAPlaceOutsideTheImagesIsRefused) {
  const Case c;
  LeakAlarm alarm;
  alarm.lps_mm = c.cine.grid().mm(60, 16, 1);
  EXPECT_THROW((void)leak_png(c.cine, c.segmentation, alarm), Error);
}

TEST(Overlay, ShowsWholeSlicesWhereNothingWasFound) {
  Case c;
  c.segmentation.coverage.phases.clear();
  EXPECT_FALSE(decode(overlay_png(c.cine, c.segmentation)).empty());
}

}  // namespace
}  // namespace beatlas::report
