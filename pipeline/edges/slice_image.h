#pragma once
/// Slices of voxels as matrices.

#include <cstdint>
#include <vector>

#include <opencv2/core.hpp>

#include "pipeline/core/grid.h"

namespace beatlas::edges {

/// One slice of one phase as a matrix that shares the voxels.
[[nodiscard]] cv::Mat slice_of(const Grid& grid, const std::vector<float>& image, int k);
[[nodiscard]] cv::Mat slice_of(const Grid& grid, const std::vector<std::uint8_t>& image, int k);

/// Structuring element of a disc, at least one pixel in radius.
[[nodiscard]] cv::Mat disc(double radius_mm, const cv::Point2d& pixel_mm);

/// The part of a slice that holds the mask, with `room_px` around it; empty if there is none.
[[nodiscard]] cv::Rect rect_around(const cv::Mat& mask, int room_px);

}  // namespace beatlas::edges
