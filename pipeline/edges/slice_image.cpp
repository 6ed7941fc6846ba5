#include "pipeline/edges/slice_image.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace beatlas::edges {

cv::Mat disc(double radius_mm, const cv::Point2d& pixel_mm) {
  const int rx = std::max(1, static_cast<int>(std::lround(radius_mm / pixel_mm.x)));
  const int ry = std::max(1, static_cast<int>(std::lround(radius_mm / pixel_mm.y)));
  return cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * rx + 1, 2 * ry + 1});
}

cv::Rect rect_around(const cv::Mat& mask, int room_px) {
  const cv::Rect around = cv::boundingRect(mask);
  if (around.empty()) return {};
  return (around - cv::Point(room_px, room_px) + cv::Size(2 * room_px, 2 * room_px)) &
         cv::Rect({0, 0}, mask.size());
}

cv::Mat slice_of(const Grid& grid, const std::vector<float>& image, int k) {
  return {grid.size[1], grid.size[0], CV_32F,
          const_cast<float*>(image.data() + grid.offset(0, 0, k))};
}

cv::Mat slice_of(const Grid& grid, const std::vector<std::uint8_t>& image, int k) {
  return {grid.size[1], grid.size[0], CV_8U,
          const_cast<std::uint8_t*>(image.data() + grid.offset(0, 0, k))};
}

}  // namespace beatlas::edges
