#include "pipeline/report/slice_view.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "runtime/base/error.h"

namespace beatlas::report {

cv::Rect heart_rectangle(const Grid& source, const CoverageCycle& coverage,
                         const std::vector<int>& phases, double margin_mm) {
  const Grid& part = coverage.grid;
  Index3 low{part.size[0], part.size[1], 0};
  Index3 high{-1, -1, 0};
  for (const auto& [structure, cycle] : coverage.phases) {
    for (int phase : phases) {
      const std::vector<float>& voxels = cycle[static_cast<std::size_t>(phase)];
      std::size_t at = 0;
      for (int k = 0; k < part.size[2]; ++k) {
        for (int j = 0; j < part.size[1]; ++j) {
          for (int i = 0; i < part.size[0]; ++i, ++at) {
            if (voxels[at] < 0.5F) continue;
            low = {std::min(low[0], i), std::min(low[1], j), 0};
            high = {std::max(high[0], i), std::max(high[1], j), 0};
          }
        }
      }
    }
  }
  const cv::Rect whole(0, 0, source.size[0], source.size[1]);
  if (high[0] < 0) return whole;
  const Vec3 spacing = source.spacing_mm();
  const int margin_i = static_cast<int>(std::ceil(margin_mm / spacing[0]));
  const int margin_j = static_cast<int>(std::ceil(margin_mm / spacing[1]));
  return whole & cv::Rect(coverage.first[0] + low[0] - margin_i,
                          coverage.first[1] + low[1] - margin_j,
                          high[0] - low[0] + 1 + 2 * margin_i, high[1] - low[1] + 1 + 2 * margin_j);
}

cv::Mat slice_view(const std::vector<float>& voxels, const Grid& grid, int k) {
  return {grid.size[1], grid.size[0], CV_32F,
          const_cast<float*>(voxels.data()) + grid.offset(0, 0, k)};
}

std::array<double, 2> grey_window(const Cine& cine, const std::vector<int>& phases,
                                  const cv::Rect& rectangle) {
  std::vector<float> sample;
  for (const int phase : phases) {
    for (int k = 0; k < cine.grid().size[2]; ++k) {
      const cv::Mat part = slice_view(cine.images.phases[static_cast<std::size_t>(phase)],
                                      cine.grid(), k)(rectangle);
      for (int j = 0; j < part.rows; ++j) {
        for (int i = 0; i < part.cols; ++i) {
          if (std::isfinite(part.at<float>(j, i))) sample.push_back(part.at<float>(j, i));
        }
      }
    }
  }
  if (sample.empty()) return {0, 1};
  const auto quantile = [&](double q) {
    const auto at = static_cast<std::ptrdiff_t>(q * static_cast<double>(sample.size() - 1));
    std::nth_element(sample.begin(), sample.begin() + at, sample.end());
    return static_cast<double>(sample[static_cast<std::size_t>(at)]);
  };
  const double low = quantile(0.01);
  const double high = quantile(0.99);
  return {low, high > low ? high : low + 1};
}

cv::Mat coverage_slice(const CoverageCycle& coverage, const std::vector<float>& voxels, int k,
                       const cv::Rect& rectangle) {
  cv::Mat out = cv::Mat::zeros(rectangle.size(), CV_32F);
  const int part_k = k - coverage.first[2];
  if (part_k < 0 || part_k >= coverage.grid.size[2]) return out;
  const cv::Rect part(coverage.first[0], coverage.first[1], coverage.grid.size[0],
                      coverage.grid.size[1]);
  const cv::Rect shared = part & rectangle;
  if (shared.empty()) return out;
  slice_view(voxels, coverage.grid, part_k)(shared - part.tl())
      .copyTo(out(shared - rectangle.tl()));
  return out;
}

void check_fit(const Cine& cine, const Segmentation& segmentation) {
  const auto phases = static_cast<std::size_t>(cine.phase_count());
  const CoverageCycle& coverage = segmentation.coverage;
  bool fits = phases > 0 && cine.grid().count() > 0;
  for (const std::vector<float>& image : cine.images.phases) {
    fits = fits && image.size() == cine.grid().count();
  }
  for (const auto& [structure, cycle] : coverage.phases) {
    fits = fits && cycle.size() == phases;
    for (const std::vector<float>& phase : cycle)
      fits = fits && phase.size() == coverage.grid.count();
  }
  for (int axis = 0; axis < 3; ++axis) {
    fits = fits && coverage.first[axis] >= 0 &&
           coverage.first[axis] + coverage.grid.size[axis] <= cine.grid().size[axis];
  }
  for (const auto& [structure, plane] : segmentation.valve_planes) {
    fits = fits && plane.k.size() == phases;
  }
  for (int phase : {segmentation.end_diastole, segmentation.end_systole}) {
    fits = fits && phase >= 0 && static_cast<std::size_t>(phase) < phases;
  }
  if (!fits) throw_invalid("the segmentation does not lie on the phases and grid of the images");
}

}  // namespace beatlas::report
