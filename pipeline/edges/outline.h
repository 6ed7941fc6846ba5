#pragma once
/// An outline in the plane of a slice, and what pixels beside it hold of either side.

#include <opencv2/core.hpp>

namespace beatlas::edges {

/// Signed distance [pixels] of each pixel to the outline of a mask (8 bit), negative inside,
/// smoothed a little: the outline of pixels is a staircase, that of a heart is not.
[[nodiscard]] cv::Mat outline_distance_px(const cv::Mat& mask);

/// How far [pixels] the smoothing looks.
inline constexpr int kOutlineReachPx = 4;

/// Coverage of a pixel, and how fast it falls with the distance to the outline.
struct Ramp {
  float coverage = 0;
  float slope = 0;
};

/// @param distance_px of the pixel's middle  @param lean_px that the outline moves from slice to
/// slice: what a thick voxel holds is a mean over as wide a strip
[[nodiscard]] Ramp ramp(float distance_px, float lean_px);

}  // namespace beatlas::edges
