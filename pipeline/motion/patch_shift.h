#pragma once
/// Translation of one image against another, by least squares.

#include <opencv2/core.hpp>

#include "runtime/base/geometry.h"

namespace beatlas::motion {

struct PatchShift {
  Vec2 shift_px = Vec2::Zero();  ///< what is at x in the first image is at x + shift in the second
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();  ///< [1/px^2] inverse covariance
};

/// Of a whole image (32-bit float) against another of its size: coarse to fine, from no shift,
/// with Cauchy's weights, so that what most pixels do decides.
[[nodiscard]] Vec2 whole_shift_px(const cv::Mat& first, const cv::Mat& second);

/// Of the patch `where` of the first image, from `start_px`. Lucas and Kanade (1981).
[[nodiscard]] PatchShift follow_patch(const cv::Mat& first, const cv::Mat& second,
                                      const cv::Rect& where, const Vec2& start_px);

}  // namespace beatlas::motion
