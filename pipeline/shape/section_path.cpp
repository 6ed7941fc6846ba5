#include "pipeline/shape/section_path.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <opencv2/core.hpp>

#include "pipeline/core/parallel.h"

namespace beatlas::shape {
namespace {

/// Of the best overlap: less is not worth a longer step. Where one section lies within the other
/// every step that leaves it there is as good.
constexpr double kNearlyAsGood = 0.98;

/// Spectrum of a slice with room for steps beyond its rim; empty without a section.
cv::Mat spectrum(const Grid& grid, const std::vector<float>& coverage, int k,
                 const cv::Size& size) {
  const cv::Mat slice(grid.size[1], grid.size[0], CV_32F,
                      const_cast<float*>(coverage.data() + grid.offset(0, 0, k)));
  const cv::Mat inside = slice >= 0.5F;
  if (cv::countNonZero(inside) == 0) return {};
  cv::Mat padded = cv::Mat::zeros(size, CV_32F);
  inside.convertTo(padded(cv::Rect(0, 0, grid.size[0], grid.size[1])), CV_32F, 1.0 / 255);
  cv::Mat out;
  cv::dft(padded, out, 0, grid.size[1]);
  return out;
}

/// @param overlap of sections, by step, steps to the left and up at the far end
Eigen::Vector2d best_step(const cv::Mat& overlap, const Grid& grid, double most_mm) {
  const Vec3 spacing = grid.spacing_mm();
  const int most_x = static_cast<int>(most_mm / spacing[0]);
  const int most_y = static_cast<int>(most_mm / spacing[1]);
  const auto each = [&](const auto& visit) {
    for (int y = -most_y; y <= most_y; ++y) {
      for (int x = -most_x; x <= most_x; ++x) {
        const double far = std::hypot(x * spacing[0], y * spacing[1]);
        if (far > most_mm) continue;
        visit(x, y, far,
              static_cast<double>(overlap.at<float>((y + overlap.rows) % overlap.rows,
                                                    (x + overlap.cols) % overlap.cols)));
      }
    }
  };
  double most = 0;
  each([&](int, int, double, double shared) { most = std::max(most, shared); });
  Eigen::Vector2d out = Eigen::Vector2d::Zero();
  double least_far = std::numeric_limits<double>::infinity();
  each([&](int x, int y, double far, double shared) {
    if (shared < kNearlyAsGood * most || !(far < least_far)) return;
    least_far = far;
    out = {x, y};
  });
  return out;
}

}  // namespace

SectionPath section_path(const Grid& grid, const std::vector<std::vector<float>>& phases) {
  const Vec3 spacing = grid.spacing_mm();
  const double most_mm = spacing[2];
  const cv::Size size(
      cv::getOptimalDFTSize(grid.size[0] + static_cast<int>(most_mm / spacing[0]) + 1),
      cv::getOptimalDFTSize(grid.size[1] + static_cast<int>(most_mm / spacing[1]) + 1));
  const auto slices = static_cast<std::size_t>(grid.size[2]);
  SectionPath steps(slices, Eigen::Vector2d::Zero());  // from the slice before
  parallel_for(slices, [&](std::size_t k) {
    if (k == 0) return;
    cv::Mat sum = cv::Mat::zeros(size, CV_32F);
    bool any = false;
    for (const std::vector<float>& coverage : phases) {
      const cv::Mat before = spectrum(grid, coverage, static_cast<int>(k) - 1, size);
      const cv::Mat here = spectrum(grid, coverage, static_cast<int>(k), size);
      if (before.empty() || here.empty()) continue;
      cv::Mat both;
      cv::mulSpectrums(here, before, both, 0, true);
      sum += both;
      any = true;
    }
    if (!any) return;
    cv::Mat overlap;
    cv::idft(sum, overlap, cv::DFT_SCALE | cv::DFT_REAL_OUTPUT);
    steps[k] = best_step(overlap, grid, most_mm);
  });
  for (std::size_t k = 1; k < slices; ++k) steps[k] += steps[k - 1];
  return steps;
}

}  // namespace beatlas::shape
