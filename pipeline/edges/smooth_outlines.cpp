#include "pipeline/edges/smooth_outlines.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "pipeline/core/parallel.h"
#include "pipeline/core/slices.h"
#include "pipeline/edges/slice_image.h"
#include "runtime/atlas/structures.h"

namespace beatlas::edges {
namespace {

/// Outer outlines in thick slices, where fat and liver blur into the wall, are smoothed this much
/// more.
constexpr double kThickOutsideFactor = 1.75;
constexpr double kFarOutsideMm = 30;  ///< farther from an outline is as far

/// Nested sets, so that each surface is smoothed once: the heart, cavities and the aorta, the LV's
/// outside, its cavity. A later one is painted over those before it.
struct NestedSet {
  std::uint8_t label;                ///< that it is painted with
  std::vector<std::uint8_t> within;  ///< labels that it holds
};

/// To the nearest pixel of the mask [mm]; far where it has none.
cv::Mat distance_from(const cv::Mat& mask, double pixel_mm) {
  if (cv::countNonZero(mask) == 0) return {mask.size(), CV_32F, cv::Scalar(kFarOutsideMm)};
  cv::Mat distance;
  cv::distanceTransform(mask == 0, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  return distance * pixel_mm;
}

}  // namespace

void smooth_outlines(ImageCycle<std::uint8_t>& labels, double sigma_mm) {
  const Grid& grid = labels.grid;
  const Vec3 spacing = grid.spacing_mm();
  const double pixel_mm = std::sqrt(spacing[0] * spacing[1]);
  const bool thick = are_thick_slices(spacing[2]);
  const std::array<NestedSet, 7> sets{{{kLabelRestOfHeart, {1, 2, 3, 4, 5, 6, 7}},
                                       {kLabelAorta, {kLabelAorta}},
                                       {kLabelLaBlood, {kLabelLaBlood}},
                                       {kLabelRaBlood, {kLabelRaBlood}},
                                       {kLabelRvBlood, {kLabelRvBlood}},
                                       {kLabelLvMyocardium, {kLabelLvMyocardium, kLabelLvBlood}},
                                       {kLabelLvBlood, {kLabelLvBlood}}}};
  const auto slices = static_cast<std::size_t>(grid.size[2]);
  parallel_for(labels.phases.size() * slices, [&](std::size_t at) {
    const std::vector<std::uint8_t>& phase = labels.phases[at / slices];
    cv::Mat slice = slice_of(grid, phase, static_cast<int>(at % slices));
    const cv::Mat before = slice.clone();
    slice.setTo(cv::Scalar(kLabelBackground));
    for (const NestedSet& set : sets) {
      const bool outside = set.label == kLabelRestOfHeart || set.label == kLabelLvMyocardium;
      const double sigma_px = sigma_mm * (thick && outside ? kThickOutsideFactor : 1.0) / pixel_mm;
      cv::Mat mask = cv::Mat::zeros(before.size(), CV_8U);
      for (const std::uint8_t label : set.within) mask |= before == label;
      // Farther from the outline than the Gaussian reaches nothing can come below zero.
      const int room = 2 * static_cast<int>(std::ceil(4 * sigma_px + 1)) + 1;
      const cv::Rect part = rect_around(mask, room);
      if (part.empty()) continue;
      mask = mask(part);
      const cv::Mat d = distance_from(mask, pixel_mm) - distance_from(~mask, pixel_mm);
      cv::Mat smoothed;
      cv::GaussianBlur(cv::min(cv::max(d, -kFarOutsideMm), kFarOutsideMm), smoothed, {0, 0},
                       sigma_px);
      slice(part).setTo(cv::Scalar(set.label), smoothed < 0);
    }
  });
}

}  // namespace beatlas::edges
