#include "pipeline/segment/boundary.h"

#include <algorithm>

#include <opencv2/imgproc.hpp>

namespace beatlas::segment {
namespace {

constexpr double kWindowMm = 3.5;  ///< half width of the window that tells a side's level

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

}  // namespace

std::vector<float> boundary_coverage(const Grid& grid, const std::vector<float>& image,
                                     const std::vector<std::uint8_t>& inside,
                                     const std::vector<std::uint8_t>& reference, double contrast) {
  std::vector<float> coverage(image.size());
  const Vec3 spacing = grid.spacing_mm();
  const cv::Size window(2 * std::max(2, static_cast<int>(std::lround(kWindowMm / spacing[0]))) + 1,
                        2 * std::max(2, static_cast<int>(std::lround(kWindowMm / spacing[1]))) + 1);
  const cv::Mat cross = cv::getStructuringElement(cv::MORPH_CROSS, {3, 3});
  for (int k = 0; k < grid.size[2]; ++k) {
    const std::size_t begin = grid.offset(0, 0, k);
    const cv::Mat pixels(grid.size[1], grid.size[0], CV_32F,
                         const_cast<float*>(image.data() + begin));
    const cv::Mat in = cv::Mat(grid.size[1], grid.size[0], CV_8U,
                               const_cast<std::uint8_t*>(inside.data() + begin)) != 0;
    const cv::Mat told = cv::Mat(grid.size[1], grid.size[0], CV_8U,
                                 const_cast<std::uint8_t*>(reference.data() + begin)) != 0;
    cv::Mat out(grid.size[1], grid.size[0], CV_32F, coverage.data() + begin);
    in.convertTo(out, CV_32F, 1.0 / 255.0);
    if (cv::countNonZero(in) == 0) continue;

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

    // A band of two pixels on each side of the boundary is decided by intensity.
    cv::Mat shrunk;
    cv::erode(in, shrunk, cross, {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar(255));
    const cv::Mat band = grown & ~shrunk;
    cv::Mat smooth;
    cv::GaussianBlur(out, smooth, {0, 0}, 0.8);
    for (int j = 0; j < out.rows; ++j) {
      for (int i = 0; i < out.cols; ++i) {
        if (!band.at<std::uint8_t>(j, i)) continue;
        const float difference = inner.at<float>(j, i) - outer.at<float>(j, i);
        const bool known = thin_weight.at<float>(j, i) > 0 &&
                           outer_weight.at<float>(j, i) > 0.02F && std::abs(difference) > contrast;
        out.at<float>(j, i) =
            known ? std::clamp((pixels.at<float>(j, i) - outer.at<float>(j, i)) / difference, 0.0F,
                               1.0F)
                  : smooth.at<float>(j, i);
      }
    }
  }
  return coverage;
}

}  // namespace beatlas::segment
