#include "pipeline/segment/boundary.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "pipeline/segment/chambers.h"

namespace beatlas::segment {
namespace {

constexpr float kBandPx = 2.0F;        ///< where intensity is asked, on both sides
constexpr double kAlongPx = 1.5;       ///< Gaussian along the outline
constexpr float kMostShiftPx = 1.25F;  ///< labels are no farther off than this
constexpr double kWindowMm = 3.5;      ///< half width of the window that tells a side's level

/// Mean of `image` over the voxels of `mask` in a window around each pixel; `weight` gets how
/// many there were, as a share of the window.
cv::Mat masked_mean(const cv::Mat& image, const cv::Mat& mask, const cv::Size& window,
                    cv::Mat& weight) {
  cv::Mat indicator;
  mask.convertTo(indicator, CV_32F, 1.0 / 255.0);
  cv::Mat sum;
  cv::boxFilter(image.mul(indicator), sum, CV_32F, window, {-1, -1}, true, cv::BORDER_ISOLATED);
  cv::boxFilter(indicator, weight, CV_32F, window, {-1, -1}, true, cv::BORDER_ISOLATED);
  return sum / cv::max(weight, 1e-6);
}

/// Signed distance [pixels] to the outline of a mask, negative inside, smoothed a little: the
/// outline of pixels is a staircase, that of a heart is not.
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

}  // namespace

std::vector<float> outline_coverage(const Grid& grid, const std::vector<std::uint8_t>& inside) {
  std::vector<float> coverage(inside.size());
  for (int k = 0; k < grid.size[2]; ++k) {
    const std::size_t begin = grid.offset(0, 0, k);
    const cv::Mat in = cv::Mat(grid.size[1], grid.size[0], CV_8U,
                               const_cast<std::uint8_t*>(inside.data() + begin)) != 0;
    cv::Mat out(grid.size[1], grid.size[0], CV_32F, coverage.data() + begin);
    in.convertTo(out, CV_32F, 1.0 / 255.0);
    const int within = cv::countNonZero(in);
    if (within == 0 || within == in.rows * in.cols) continue;
    const cv::Mat covered = 0.5F - outline_distance_px(in);
    out = cv::min(cv::max(covered, 0.0F), 1.0F);  // assigns into `coverage`: same size and type
  }
  return coverage;
}

std::vector<float> boundary_coverage(const Grid& grid, const std::vector<float>& image,
                                     const std::vector<std::uint8_t>& inside,
                                     const std::vector<std::uint8_t>& reference, double contrast) {
  std::vector<float> coverage(image.size());
  const Vec3 spacing = grid.spacing_mm();
  const cv::Size window(2 * std::max(2, static_cast<int>(std::lround(kWindowMm / spacing[0]))) + 1,
                        2 * std::max(2, static_cast<int>(std::lround(kWindowMm / spacing[1]))) + 1);
  const cv::Mat cross = cv::getStructuringElement(cv::MORPH_CROSS, {3, 3});
  // The band along the outline, what its levels are told by, and what its distance is smoothed by.
  const int room = 16 + std::max(window.width, window.height);
  for (int k = 0; k < grid.size[2]; ++k) {
    const std::size_t begin = grid.offset(0, 0, k);
    const cv::Mat whole(grid.size[1], grid.size[0], CV_8U,
                        const_cast<std::uint8_t*>(inside.data() + begin));
    const cv::Rect part = rect_around(whole, room);
    if (part.empty()) continue;
    const cv::Mat pixels =
        cv::Mat(grid.size[1], grid.size[0], CV_32F, const_cast<float*>(image.data() + begin))(part);
    const cv::Mat in = whole(part) != 0;
    const cv::Mat told = cv::Mat(grid.size[1], grid.size[0], CV_8U,
                                 const_cast<std::uint8_t*>(reference.data() + begin))(part) != 0;
    cv::Mat out = cv::Mat(grid.size[1], grid.size[0], CV_32F, coverage.data() + begin)(part);
    in.convertTo(out, CV_32F, 1.0 / 255.0);

    // Levels are told by voxels that are whole: one pixel or more off the boundary; thin walls
    // have none, there the boundary's own inner pixels must do.
    cv::Mat core;
    cv::erode(in, core, cross, {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar(255));
    core &= told;
    cv::Mat grown;
    cv::dilate(in, grown, cross);
    cv::Mat inner_weight;
    cv::Mat inner = masked_mean(pixels, core, window, inner_weight);
    cv::Mat thin_weight;
    const cv::Mat thin = masked_mean(pixels, in & told, window, thin_weight);
    thin.copyTo(inner, inner_weight < 0.03F);
    cv::Mat outer_weight;
    const cv::Mat outer = masked_mean(pixels, ~grown, window, outer_weight);

    // Geometry first: coverage g of the mask's own smooth outline. Intensity then tells by how much
    // that outline must move: across the boundary the excess of measured coverage over g adds up to
    // the shift, in pixels. Averaged along the outline, so that noise and single odd pixels cancel.
    const cv::Mat distance_px = outline_distance_px(in);
    cv::Mat geometric = 0.5F - distance_px;
    geometric = cv::min(cv::max(geometric, 0.0F), 1.0F);
    cv::Mat excess = cv::Mat::zeros(out.size(), CV_32F);
    cv::Mat trusted = cv::Mat::zeros(out.size(), CV_32F);
    for (int j = 0; j < out.rows; ++j) {
      for (int i = 0; i < out.cols; ++i) {
        const float d = distance_px.at<float>(j, i);
        if (std::abs(d) > kBandPx) continue;
        const float difference = inner.at<float>(j, i) - outer.at<float>(j, i);
        if (thin_weight.at<float>(j, i) <= 0 || outer_weight.at<float>(j, i) <= 0.02F ||
            std::abs(difference) <= contrast) {
          continue;
        }
        const float measured =
            std::clamp((pixels.at<float>(j, i) - outer.at<float>(j, i)) / difference, 0.0F, 1.0F);
        // A dark spot inside was taken in on purpose (papillary muscle): it says nothing.
        if (d < 0 && measured < 0.2F) continue;
        trusted.at<float>(j, i) = 1;
        excess.at<float>(j, i) = measured - geometric.at<float>(j, i);
      }
    }
    cv::Mat dx;
    cv::Mat dy;
    cv::Sobel(geometric, dx, CV_32F, 1, 0, 1, 0.5);
    cv::Sobel(geometric, dy, CV_32F, 0, 1, 1, 0.5);
    cv::Mat length;
    cv::magnitude(dx, dy, length);
    cv::Mat moved;
    cv::Mat along;
    cv::GaussianBlur(excess, moved, {0, 0}, kAlongPx, kAlongPx, cv::BORDER_ISOLATED);
    cv::GaussianBlur(length.mul(trusted), along, {0, 0}, kAlongPx, kAlongPx, cv::BORDER_ISOLATED);
    for (int j = 0; j < out.rows; ++j) {
      for (int i = 0; i < out.cols; ++i) {
        const float d = distance_px.at<float>(j, i);
        if (std::abs(d) > kBandPx + kMostShiftPx) continue;
        const float weight = along.at<float>(j, i);
        const float shift =
            weight > 0.02F ? std::clamp(moved.at<float>(j, i) / weight, -kMostShiftPx, kMostShiftPx)
                           : 0.0F;
        out.at<float>(j, i) = std::clamp(0.5F - d + shift, 0.0F, 1.0F);
      }
    }
  }
  return coverage;
}

}  // namespace beatlas::segment
