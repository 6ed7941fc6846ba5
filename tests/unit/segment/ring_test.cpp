#include "pipeline/segment/ring.h"

#include <cmath>
#include <functional>
#include <numbers>

#include <gtest/gtest.h>

namespace beatlas::segment {
namespace {

constexpr double kPixelMm = 1.5;
constexpr double kEndoMm = 20;
constexpr double kEpiMm = 28;
constexpr double kBlood = 1000;
constexpr double kMuscle = 300;
constexpr double kLung = 30;
/// Rays go in steps of half a millimetre and report the first sample past an edge; pixels of 1.5 mm
/// interpolate an edge of one pixel to a tenth of one. Both are below a pixel.
constexpr double kStepMm = 0.5;
constexpr double kSlackMm = 0.15;

const cv::Point2d kPixel(kPixelMm, kPixelMm);
const TissueLevels kLevels{kBlood, kBlood, kMuscle, 0.5 * (kBlood + kMuscle), 0.5 * kMuscle};

/// A slice whose pixels are the mean of what `signal` says at points (x, y) [mm] in them.
cv::Mat slice_of_signal(int columns, int rows, const cv::Point2d& pixel_mm,
                        const std::function<double(double, double)>& signal) {
  constexpr int kSteps = 8;
  cv::Mat image(rows, columns, CV_32F);
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      double sum = 0;
      for (int b = 0; b < kSteps; ++b) {
        for (int a = 0; a < kSteps; ++a) {
          sum += signal((i + (a + 0.5) / kSteps - 0.5) * pixel_mm.x,
                        (j + (b + 0.5) / kSteps - 0.5) * pixel_mm.y);
        }
      }
      image.at<float>(j, i) = static_cast<float>(sum / (kSteps * kSteps));
    }
  }
  return image;
}

/// Blood in an annulus of muscle about (x, y) [mm], `around` beyond it.
std::function<double(double, double)> ventricle(double x0, double y0, double around) {
  return [=](double x, double y) {
    const double r = std::hypot(x - x0, y - y0);
    return r < kEndoMm ? kBlood : r < kEpiMm ? kMuscle : around;
  };
}

constexpr double kMiddleMm = 60.4;

class RingOf : public testing::TestWithParam<double> {};

TEST_P(RingOf, a_disc_of_blood_in_an_annulus_of_muscle_has_both_radii) {
  const cv::Mat image =
      slice_of_signal(81, 81, kPixel, ventricle(kMiddleMm, kMiddleMm, GetParam()));
  const Ring ring =
      trace_ring(image, kPixel, {kMiddleMm / kPixelMm, kMiddleMm / kPixelMm}, kLevels);
  ASSERT_EQ(ring.endo_mm.size(), std::size_t{Ring::kRays});
  for (std::size_t a = 0; a < Ring::kRays; ++a) {
    EXPECT_GE(ring.endo_mm[a], kEndoMm - kSlackMm) << a;
    EXPECT_LE(ring.endo_mm[a], kEndoMm + kStepMm + kSlackMm) << a;
    EXPECT_GE(ring.outer_mm[a], kEpiMm - kSlackMm) << a;
    EXPECT_LE(ring.outer_mm[a], kEpiMm + kStepMm + kSlackMm) << a;
    EXPECT_TRUE(ring.walled[a]) << a;
  }
  EXPECT_EQ(ring.walled_share, 1);
  EXPECT_NEAR(ring.median_wall_mm(), kEpiMm - kEndoMm, kStepMm);
  // Area between the smallest and largest radius that a step allows; 64 rays miss 0.2 % of it.
  const auto disc = [](double r) { return std::numbers::pi * r * r; };
  EXPECT_GE(ring.area_mm2, 0.998 * disc(kEndoMm));
  EXPECT_LE(ring.area_mm2, disc(kEndoMm + kStepMm));
  EXPECT_GT(ring.roundness, 1 - 0.5 * kStepMm / kEndoMm);
}

// Lung's edge is met half-way between muscle and lung, other blood's half-way between those.
INSTANTIATE_TEST_SUITE_P(LungOrBloodBeyond, RingOf, testing::Values(kLung, kBlood));

TEST(Ring, from_a_point_off_centre_meets_the_circle_where_geometry_says) {
  const cv::Mat image = slice_of_signal(81, 81, kPixel, ventricle(kMiddleMm, kMiddleMm, kLung));
  const double dx = 8;
  const double dy = -5;
  const Ring ring = trace_ring(image, kPixel,
                               {(kMiddleMm + dx) / kPixelMm, (kMiddleMm + dy) / kPixelMm}, kLevels);
  double mean = 0;
  double square = 0;
  for (int a = 0; a < Ring::kRays; ++a) {
    const double angle = 2 * std::numbers::pi * a / Ring::kRays;
    const double along = dx * std::cos(angle) + dy * std::sin(angle);
    const double expected =
        -along + std::sqrt(along * along - dx * dx - dy * dy + kEndoMm * kEndoMm);
    EXPECT_GE(ring.endo_mm[static_cast<std::size_t>(a)], expected - kSlackMm) << a;
    EXPECT_LE(ring.endo_mm[static_cast<std::size_t>(a)], expected + kStepMm + 2 * kSlackMm) << a;
    mean += expected / Ring::kRays;
    square += expected * expected / Ring::kRays;
  }
  // The spread of the radii is millimetres; a step changes it by a tenth of that.
  EXPECT_NEAR(ring.roundness, 1 - std::sqrt(square - mean * mean) / mean, 0.02);
}

TEST(Ring, follows_the_millimetres_of_oblong_pixels) {
  const cv::Point2d oblong(1.0, 2.0);
  const cv::Mat image = slice_of_signal(121, 61, oblong, ventricle(kMiddleMm, kMiddleMm, kLung));
  const Ring ring = trace_ring(image, oblong, {kMiddleMm / 1.0, kMiddleMm / 2.0}, kLevels);
  for (float r : ring.endo_mm) EXPECT_NEAR(r, kEndoMm + 0.5 * kStepMm, 0.5 * kStepMm + 0.25);
}

TEST(Ring, counts_only_rays_that_meet_a_wall) {
  // A quarter of the wall is missing; there lung follows on blood.
  const auto gap = [](double x, double y) {
    const double angle = std::atan2(y - kMiddleMm, x - kMiddleMm);
    const double r = std::hypot(x - kMiddleMm, y - kMiddleMm);
    const bool open = std::abs(angle) < std::numbers::pi / 4;
    return r < kEndoMm ? kBlood : r < kEpiMm && !open ? kMuscle : kLung;
  };
  const cv::Mat image = slice_of_signal(81, 81, kPixel, gap);
  const Ring ring =
      trace_ring(image, kPixel, {kMiddleMm / kPixelMm, kMiddleMm / kPixelMm}, kLevels);
  // One ray more or less on either side of the gap.
  EXPECT_NEAR(ring.walled_share, 0.75, 2.0 / Ring::kRays);
  EXPECT_FALSE(ring.walled[0]);
  EXPECT_TRUE(ring.walled[Ring::kRays / 2]);
  EXPECT_NEAR(ring.median_wall_mm(), kEpiMm - kEndoMm, kStepMm);
}

TEST(Ring, passes_trabeculae_thinner_than_a_wall) {
  // A dark web of 1.5 mm inside the pool is no end of the blood.
  const auto web = [](double x, double y) {
    const double r = std::hypot(x - kMiddleMm, y - kMiddleMm);
    if (r > 10 && r < 11.5) return kMuscle;
    return ventricle(kMiddleMm, kMiddleMm, kLung)(x, y);
  };
  const cv::Point2d fine(0.75, 0.75);
  const cv::Mat image = slice_of_signal(161, 161, fine, web);
  const Ring ring = trace_ring(image, fine, {kMiddleMm / 0.75, kMiddleMm / 0.75}, kLevels);
  for (float r : ring.endo_mm) EXPECT_GT(r, kEndoMm - kSlackMm);
}

TEST(Ring, from_a_point_in_muscle_has_no_area_and_no_wall) {
  const cv::Mat image = slice_of_signal(81, 81, kPixel, ventricle(kMiddleMm, kMiddleMm, kLung));
  const Ring ring =
      trace_ring(image, kPixel, {(kMiddleMm + 24) / kPixelMm, kMiddleMm / kPixelMm}, kLevels);
  EXPECT_EQ(ring.area_mm2, 0);
  EXPECT_EQ(ring.walled_share, 0);
  EXPECT_EQ(ring.roundness, 0);
  EXPECT_EQ(ring.median_wall_mm(), 0);
}

TEST(Ring, takes_the_border_of_the_image_for_no_end_of_a_wall) {
  // Muscle all the way to the border, 20 mm behind the blood: no outer edge is seen.
  const cv::Mat image = slice_of_signal(54, 54, kPixel, ventricle(40, 40, kMuscle));
  const Ring ring = trace_ring(image, kPixel, {40 / kPixelMm, 40 / kPixelMm}, kLevels);
  EXPECT_EQ(ring.walled_share, 0);
  for (float r : ring.endo_mm) EXPECT_NEAR(r, kEndoMm + 0.5 * kStepMm, 0.5 * kStepMm + kSlackMm);
}

TEST(Ring, ends_at_the_border_of_the_image) {
  const cv::Mat all_blood(20, 20, CV_32F, cv::Scalar(kBlood));
  const Ring ring = trace_ring(all_blood, kPixel, {10, 10}, kLevels);
  EXPECT_EQ(ring.walled_share, 0);
  for (float r : ring.endo_mm) EXPECT_LE(r, std::hypot(10, 10) * kPixelMm + kStepMm);
}

}  // namespace
}  // namespace beatlas::segment
