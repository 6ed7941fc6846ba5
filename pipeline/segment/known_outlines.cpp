#include "pipeline/segment/known_outlines.h"

#include <algorithm>

#include <opencv2/imgproc.hpp>

namespace beatlas::segment {
namespace {

constexpr double kBandPx = 1.5;   ///< around an outline, where two distances tell an offset
constexpr double kNearMm = 6;     ///< Gaussian over which offsets are one
constexpr double kMostOffMm = 3;  ///< farther off lies no outline but another thing

/// What has to be added to `grown`, everywhere, to meet `given`; zeros where either has no outline.
cv::Mat offset_between(const cv::Mat& grown, const cv::Mat& given, double pixel_mm) {
  const cv::Mat near_grown = cv::abs(grown) < kBandPx * pixel_mm;
  const cv::Mat near_given = cv::abs(given) < kBandPx * pixel_mm + kMostOffMm;
  const cv::Mat told = near_grown & near_given;
  if (cv::countNonZero(told) == 0) return cv::Mat::zeros(grown.size(), CV_32F);
  cv::Mat weight;
  told.convertTo(weight, CV_32F, 1.0 / 255.0);
  cv::Mat offset = (given - grown).mul(weight);
  const double sigma_px = kNearMm / pixel_mm;
  cv::GaussianBlur(offset, offset, {0, 0}, sigma_px, sigma_px, cv::BORDER_ISOLATED);
  cv::GaussianBlur(weight, weight, {0, 0}, sigma_px, sigma_px, cv::BORDER_ISOLATED);
  // Far from any outline what is left is rounding: there nothing moves anyway.
  const cv::Mat mean = offset / cv::max(weight, 1e-4F);
  return cv::min(cv::max(mean, -kMostOffMm), kMostOffMm);
}

}  // namespace

void follow_known_outlines(std::vector<cv::Mat>& outlines, const std::vector<int>& phases,
                           const std::vector<cv::Mat>& given, double pixel_mm) {
  std::vector<cv::Mat> offsets;
  for (std::size_t at = 0; at < phases.size(); ++at) {
    offsets.push_back(
        offset_between(outlines[static_cast<std::size_t>(phases[at])], given[at], pixel_mm));
  }
  const int n = static_cast<int>(outlines.size());
  for (int p = 0; p < n; ++p) {
    const auto behind = std::upper_bound(phases.begin(), phases.end(), p);
    const std::size_t after =
        behind == phases.end() ? 0 : static_cast<std::size_t>(behind - phases.begin());
    const std::size_t before = after == 0 ? phases.size() - 1 : after - 1;
    const int since = (p - phases[before] + n) % n;
    const int until = (phases[after] - p + n) % n;
    const double share = since + until > 0 ? static_cast<double>(since) / (since + until) : 0.0;
    cv::Mat& outline = outlines[static_cast<std::size_t>(p)];
    outline = outline + (1 - share) * offsets[before] + share * offsets[after];
  }
}

}  // namespace beatlas::segment
