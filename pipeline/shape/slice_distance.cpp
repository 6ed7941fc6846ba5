#include "pipeline/shape/slice_distance.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace beatlas::shape {
namespace {
constexpr double kFineMm = 0.35;
}

std::vector<std::vector<float>> slice_distances(const Grid& grid,
                                                const std::vector<float>& coverage) {
  std::vector<std::vector<float>> out(static_cast<std::size_t>(grid.size[2]));
  const Vec3 spacing = grid.spacing_mm();
  // Fine pixels are square, whatever the pixels: distances are counted in them.
  const double short_mm = std::min(spacing[0], spacing[1]);
  const double fine_mm = short_mm / std::max(1.0, std::ceil(short_mm / kFineMm));
  const cv::Size fine_size(static_cast<int>(std::lround(grid.size[0] * spacing[0] / fine_mm)),
                           static_cast<int>(std::lround(grid.size[1] * spacing[1] / fine_mm)));
  for (int k = 0; k < grid.size[2]; ++k) {
    const cv::Mat slice(grid.size[1], grid.size[0], CV_32F,
                        const_cast<float*>(coverage.data() + grid.offset(0, 0, k)));
    cv::Mat fine;
    cv::resize(slice, fine, fine_size, 0, 0, cv::INTER_LINEAR);
    const cv::Mat inside = fine >= 0.5F;
    // A voxel half covered may stand between finer pixels that are all less so: nothing to be
    // distant from.
    if (cv::countNonZero(inside) == 0) continue;
    cv::Mat to_outside;
    cv::Mat to_inside;
    cv::distanceTransform(inside, to_outside, cv::DIST_L2, cv::DIST_MASK_PRECISE);
    cv::distanceTransform(~inside, to_inside, cv::DIST_L2, cv::DIST_MASK_PRECISE);
    if (cv::countNonZero(~inside) == 0) to_outside.setTo(1e3 / fine_mm);
    // Distances run between pixel centres, the contour between pixels: half a pixel comes off.
    cv::Mat signed_distance = (to_inside - to_outside) * fine_mm;
    signed_distance.forEach<float>(
        [&](float& d, const int*) { d -= static_cast<float>(std::copysign(0.5 * fine_mm, d)); });
    cv::Mat coarse;
    cv::resize(signed_distance, coarse, slice.size(), 0, 0, cv::INTER_AREA);
    out[static_cast<std::size_t>(k)].assign(coarse.begin<float>(), coarse.end<float>());
  }
  return out;
}

}  // namespace beatlas::shape
