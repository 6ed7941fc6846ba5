#include "pipeline/tissue/tissue.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "pipeline/core/parallel.h"

namespace beatlas::tissue {
namespace {

double quantile_of(std::vector<float> values, double share) {
  if (values.empty()) return 0;
  const auto index = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + index, values.end());
  return values[static_cast<std::size_t>(index)];
}

/// A Gaussian of sigma 0.7 pixel keeps 1 / (4 pi 0.49) of white noise's variance.
constexpr double kSmoothedVariance = 0.1624;

}  // namespace

double median_of(std::vector<float>& values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Noise from temporal second differences of voxels that hold signal: what is left after motion
/// slower than two phases; the median ignores the few voxels that move faster. Air is left out:
/// where there is no signal, magnitude images show only two thirds of the noise.
double noise_level(const ImageCycle<float>& images) {
  const int n = images.phase_count();
  const std::size_t count = images.grid.count();
  const std::size_t stride = std::max<std::size_t>(1, count / 200000);
  std::vector<float> sampled;
  for (std::size_t v = 0; v < count; v += stride) sampled.push_back(images.phases[0][v]);
  const double dark = quantile_of(sampled, 0.02);
  const double signal = dark + 0.2 * (quantile_of(sampled, 0.98) - dark);
  std::vector<float> residuals;
  for (std::size_t v = 0; v < count; v += stride) {
    const int p = static_cast<int>(v / stride) % n;
    const double before = images.phases[static_cast<std::size_t>((p + n - 1) % n)][v];
    const double here = images.phases[static_cast<std::size_t>(p)][v];
    const double after = images.phases[static_cast<std::size_t>((p + 1) % n)][v];
    // Of two phases each is the other's neighbour on both sides. The means choose voxels without
    // favour: they are uncorrelated with the differences.
    const double mean = n == 2 ? (here + after) / 2 : (before + here + after) / 3;
    if (mean < signal) continue;
    residuals.push_back(static_cast<float>(std::abs(here - 0.5 * (before + after)) /
                                           std::sqrt(n == 2 ? 2.0 : 1.5)));
  }
  return median_of(residuals) / 0.6745;
}

std::vector<float> smooth_in_plane(const Grid& grid, const std::vector<float>& image,
                                   double sigma_mm) {
  if (sigma_mm <= 0) return image;
  std::vector<float> out(image.size());
  const Vec3 spacing = grid.spacing_mm();
  for (int k = 0; k < grid.size[2]; ++k) {
    const std::size_t begin = grid.offset(0, 0, k);
    const cv::Mat source(grid.size[1], grid.size[0], CV_32F,
                         const_cast<float*>(image.data() + begin));
    cv::Mat target(grid.size[1], grid.size[0], CV_32F, out.data() + begin);
    cv::GaussianBlur(source, target, cv::Size(0, 0), sigma_mm / spacing[0], sigma_mm / spacing[1],
                     cv::BORDER_REPLICATE);
  }
  return out;
}

TemporalStats temporal_stats(const ImageCycle<float>& images) {
  const auto n = static_cast<std::size_t>(images.phase_count());
  const std::size_t count = images.grid.count();
  TemporalStats stats;
  stats.noise = noise_level(images);
  stats.mean.assign(count, 0);
  stats.swing.assign(count, 0);

  // One slice a task, so that only a slice's smoothed phases are alive at once.
  const std::size_t slice = images.grid.slice_count();
  const Grid slice_grid =
      images.grid.part({0, 0, 0}, {images.grid.size[0], images.grid.size[1], 1});
  const double pixel_mm = slice_grid.spacing_mm().head<2>().maxCoeff();
  parallel_for(static_cast<std::size_t>(images.grid.size[2]), [&](std::size_t k) {
    std::vector<double> sum(slice, 0);
    std::vector<double> sum_squares(slice, 0);
    std::vector<float> plane(slice);
    for (std::size_t p = 0; p < n; ++p) {
      const float* source = images.phases[p].data() + k * slice;
      plane.assign(source, source + slice);
      const std::vector<float> smooth = smooth_in_plane(slice_grid, plane, 0.7 * pixel_mm);
      for (std::size_t v = 0; v < slice; ++v) {
        sum[v] += smooth[v];
        sum_squares[v] += static_cast<double>(smooth[v]) * smooth[v];
      }
    }
    const double noise_variance = stats.noise * stats.noise * kSmoothedVariance;
    for (std::size_t v = 0; v < slice; ++v) {
      const double mean = sum[v] / static_cast<double>(n);
      const double variance = sum_squares[v] / static_cast<double>(n) - mean * mean;
      stats.mean[k * slice + v] = static_cast<float>(mean);
      stats.swing[k * slice + v] =
          static_cast<float>(std::sqrt(std::max(0.0, variance - noise_variance)));
    }
  });
  return stats;
}

}  // namespace beatlas::tissue
