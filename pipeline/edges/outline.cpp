#include "pipeline/edges/outline.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace beatlas::edges {
namespace {

constexpr float kLeastLeanPx = 0.05F;  ///< less is none

}  // namespace

cv::Mat outline_distance_px(const cv::Mat& mask) {
  cv::Mat inward;
  cv::Mat outward;
  cv::distanceTransform(mask, inward, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  cv::distanceTransform(~mask, outward, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  cv::Mat distance = outward - inward;
  distance.forEach<float>([](float& d, const int*) { d -= std::copysign(0.5F, d); });
  cv::GaussianBlur(distance, distance, {0, 0}, 1.0);
  return distance;
}

Ramp ramp(float distance_px, float lean_px) {
  const auto upright = [](float d) { return std::clamp(0.5F - d, 0.0F, 1.0F); };
  if (lean_px < kLeastLeanPx) {
    return {upright(distance_px), std::abs(distance_px) < 0.5F ? 1.0F : 0.0F};
  }
  // Integral of `upright`.
  const auto sum = [](float d) {
    const float u = std::clamp(d, -0.5F, 0.5F);
    return std::min(d, -0.5F) + 0.5F + 0.5F * (u - u * u) + 0.375F;
  };
  const float from = distance_px - 0.5F * lean_px;
  const float to = distance_px + 0.5F * lean_px;
  return {std::clamp((sum(to) - sum(from)) / lean_px, 0.0F, 1.0F),
          (upright(from) - upright(to)) / lean_px};
}

}  // namespace beatlas::edges
