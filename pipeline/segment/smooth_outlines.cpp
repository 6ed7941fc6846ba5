#include "pipeline/segment/smooth_outlines.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "pipeline/core/parallel.h"
#include "pipeline/core/slices.h"
#include "pipeline/segment/slice_image.h"
#include "runtime/atlas/structures.h"

namespace beatlas::segment {
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
  /// What an outside loses at its corners is mostly not its own, such as fat that blurs into a
  /// wall; the LV's cavity, filled to a round one before, has none.
  bool keeps_area = false;
};

/// To the nearest pixel of the mask [mm]; far where it has none.
cv::Mat distance_from(const cv::Mat& mask, double pixel_mm) {
  if (cv::countNonZero(mask) == 0) return {mask.size(), CV_32F, cv::Scalar(kFarOutsideMm)};
  cv::Mat distance;
  cv::distanceTransform(mask == 0, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  return distance * pixel_mm;
}

/// Signed distance from the mask's outline [mm], negative within, smoothed.
cv::Mat smooth_distance(const cv::Mat& mask, double pixel_mm, double sigma_px) {
  const cv::Mat d = distance_from(mask, pixel_mm) - distance_from(~mask, pixel_mm);
  cv::Mat out;
  cv::GaussianBlur(cv::min(cv::max(d, -kFarOutsideMm), kFarOutsideMm), out, {0, 0}, sigma_px);
  return out;
}

/// Takes off the mask what lies nowhere within `inside`. @return whether there was such a speck
bool drop_specks(const cv::Mat& inside, cv::Mat& mask) {
  cv::Mat pieces;
  const int count = cv::connectedComponents(mask, pieces);
  std::vector<bool> stays(static_cast<std::size_t>(count), false);
  for (int j = 0; j < mask.rows; ++j) {
    for (int i = 0; i < mask.cols; ++i) {
      if (inside.at<std::uint8_t>(j, i) != 0) {
        stays[static_cast<std::size_t>(pieces.at<int>(j, i))] = true;
      }
    }
  }
  bool dropped = false;
  for (int piece = 1; piece < count; ++piece) {
    if (stays[static_cast<std::size_t>(piece)]) continue;
    mask.setTo(cv::Scalar(0), pieces == piece);
    dropped = true;
  }
  return dropped;
}

/// The level at which a smoothed distance encloses as many pixels as the mask did: at 0 a corner,
/// say of a crescent, is cut and nothing is given back for it.
float level_around(const cv::Mat& smoothed, int pixels) {
  std::vector<float> values(smoothed.begin<float>(), smoothed.end<float>());
  const auto at = values.begin() + pixels;
  if (at == values.end()) return 0;
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// What is within the smoothed outlines of a cavity: as much as was within them, specks apart.
cv::Mat smooth_cavity(cv::Mat mask, double pixel_mm, double sigma_px) {
  cv::Mat smoothed = smooth_distance(mask, pixel_mm, sigma_px);
  if (drop_specks(smoothed < 0, mask)) smoothed = smooth_distance(mask, pixel_mm, sigma_px);
  return smoothed < level_around(smoothed, cv::countNonZero(mask));
}

}  // namespace

void smooth_outlines(ImageCycle<std::uint8_t>& labels, double sigma_mm) {
  const Grid& grid = labels.grid;
  const Vec3 spacing = grid.spacing_mm();
  const double pixel_mm = std::sqrt(spacing[0] * spacing[1]);
  const bool thick = spacing[2] >= kThickSlicesMm;
  const std::array<NestedSet, 7> sets{{{kLabelRestOfHeart, {1, 2, 3, 4, 5, 6, 7}},
                                       {kLabelAorta, {kLabelAorta}, true},
                                       {kLabelLaBlood, {kLabelLaBlood}, true},
                                       {kLabelRaBlood, {kLabelRaBlood}, true},
                                       {kLabelRvBlood, {kLabelRvBlood}, true},
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
      slice(part).setTo(cv::Scalar(set.label),
                        set.keeps_area ? smooth_cavity(mask(part), pixel_mm, sigma_px)
                                       : smooth_distance(mask(part), pixel_mm, sigma_px) < 0);
    }
  });
}

}  // namespace beatlas::segment
