#include "pipeline/edges/papillary.h"

#include <opencv2/imgproc.hpp>

#include "pipeline/core/parallel.h"
#include "pipeline/edges/slice_image.h"

namespace beatlas::edges {
namespace {

constexpr double kLeastRadiusMm = 2;
constexpr double kMuscleSmoothMm = 1;  ///< Gaussian, so that noise pierces no muscle

}  // namespace

void papillary_muscles_to_wall(const ImageCycle<float>& images, const tissue::TissueLevels& levels,
                               ImageCycle<std::uint8_t>& labels) {
  const Grid& grid = images.grid;
  const Vec3 spacing = grid.spacing_mm();
  const cv::Point2d pixel_mm(spacing[0], spacing[1]);
  const cv::Mat least = disc(kLeastRadiusMm, pixel_mm);
  parallel_for(labels.phases.size(), [&](std::size_t p) {
    for (int k = 0; k < grid.size[2]; ++k) {
      cv::Mat slice = slice_of(grid, labels.phases[p], k);
      const cv::Mat pool = slice == kLabelLvBlood;
      if (cv::countNonZero(pool) == 0) continue;
      cv::Mat smooth;
      cv::GaussianBlur(slice_of(grid, images.phases[p], k), smooth, {0, 0},
                       kMuscleSmoothMm / spacing[0], kMuscleSmoothMm / spacing[1]);
      cv::Mat muscle = (smooth < levels.threshold) & pool;
      cv::morphologyEx(muscle, muscle, cv::MORPH_OPEN, least, {-1, -1}, 1, cv::BORDER_CONSTANT,
                       cv::Scalar(0));
      slice.setTo(cv::Scalar(kLabelLvMyocardium), muscle);
    }
  });
}

}  // namespace beatlas::edges
