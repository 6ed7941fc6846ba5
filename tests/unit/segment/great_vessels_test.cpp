/// Pools about the base of a heart whose slices are 8 mm apart.
#include "pipeline/segment/great_vessels.h"

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "tests/unit/segment/made_images.h"

namespace beatlas::segment {
namespace {

constexpr int kSlices = 6;
constexpr int kBase = 3;  ///< the LV's last slice
const cv::Size kSize(100, 100);

void draw_disc(cv::Mat& mask, const cv::Point& at, int radius) {
  cv::circle(mask, at, radius, cv::Scalar(255), cv::FILLED);
}

/// An LV about (50, 50) with its zone of radius 30 in every slice.
struct Base {
  Grid grid = made::straight_grid({kSize.width, kSize.height, kSlices}, {1, 1, 8});
  Chambers chambers;
  std::vector<cv::Mat> zones;

  Base() {
    chambers.base_step = 1;
    for (int k = 0; k < kSlices; ++k) {
      cv::Mat zone = cv::Mat::zeros(kSize, CV_8U);
      draw_disc(zone, {50, 50}, 30);
      zones.push_back(zone);
      cv::Mat blood = cv::Mat::zeros(kSize, CV_8U);
      draw_disc(blood, {50, 50}, 14);
      chambers.always_blood.push_back(blood);
      if (k > kBase) continue;
      LvSlice slice;
      slice.k = k;
      slice.centre_px = {50, 50};
      chambers.lv.push_back(slice);
    }
  }
  void draw_pool(int k, const cv::Point& at, int radius) {
    draw_disc(chambers.always_blood[static_cast<std::size_t>(k)], at, radius);
  }
  [[nodiscard]] bool within(int k, const cv::Point& at) const {
    return zones[static_cast<std::size_t>(k)].at<std::uint8_t>(at) != 0;
  }
};

TEST(GreatVessels, that_lie_in_the_zone_for_the_most_part_lie_in_it_as_a_whole) {
  Base base;
  base.draw_pool(5, {50, 76}, 12);  // the ascending aorta, cut by the zone's rim at row 80
  ASSERT_FALSE(base.within(5, {50, 86}));
  take_pools_whole(base.grid, base.chambers, base.zones);
  EXPECT_TRUE(base.within(5, {50, 86}));
  EXPECT_TRUE(base.within(5, {50, 90})) << "its wall, too";
  EXPECT_FALSE(base.within(4, {50, 86})) << "no pool there";
}

TEST(GreatVessels, that_touch_the_zone_stay_out) {
  Base base;
  base.draw_pool(5, {50, 88}, 10);
  take_pools_whole(base.grid, base.chambers, base.zones);
  EXPECT_FALSE(base.within(5, {50, 92}));
}

TEST(GreatVessels, that_run_past_the_ventricle_are_not_of_the_heart) {
  Base base;
  // The descending aorta, leaning in until it lies beside the atria.
  const int rows[] = {92, 91, 89, 87, 78, 72};
  for (int k = 0; k < kSlices; ++k) base.draw_pool(k, {50, rows[k]}, 8);
  ASSERT_TRUE(base.within(5, {50, 72}));
  take_pools_whole(base.grid, base.chambers, base.zones);
  for (int k = 0; k < kSlices; ++k) EXPECT_FALSE(base.within(k, {50, rows[k]})) << "slice " << k;
  EXPECT_TRUE(base.within(5, {50, 50})) << "atria stay";
}

TEST(GreatVessels, keep_the_zones_where_there_is_no_pool) {
  Base base;
  const std::vector<cv::Mat> before{base.zones[0].clone(), base.zones[5].clone()};
  take_pools_whole(base.grid, base.chambers, base.zones);
  EXPECT_EQ(cv::norm(before[0], base.zones[0], cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(before[1], base.zones[5], cv::NORM_INF), 0);
}

}  // namespace
}  // namespace beatlas::segment
