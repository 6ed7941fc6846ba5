#include "pipeline/edges/side_levels.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "pipeline/core/slices.h"
#include "pipeline/edges/slice_image.h"

namespace beatlas::edges {
namespace {

constexpr int kLevelBandPx = 3;         ///< of the band in which levels serve, and a pixel more
constexpr double kLeastBareMm = 8;      ///< a shorter stretch without a wall is a wall not resolved
constexpr double kThinMm = 2.2;         ///< from blood to the outside: no wall is as thin
constexpr double kWindowMm = 3.5;       ///< half width of the window that tells a side's level
constexpr float kLeastOutside = 0.02F;  ///< share of the window without which there is no outside

cv::Size window_of(const Grid& grid) {
  const Vec3 spacing = grid.spacing_mm();
  return {2 * std::max(2, static_cast<int>(std::lround(kWindowMm / spacing[0]))) + 1,
          2 * std::max(2, static_cast<int>(std::lround(kWindowMm / spacing[1]))) + 1};
}

cv::Mat cross() { return cv::getStructuringElement(cv::MORPH_CROSS, {3, 3}); }

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

/// Where `bare` comes to the surface of `in` by itself, along kLeastBareMm and more, and a band's
/// width around it. Its mixed voxels look like a wall of one pixel, thinner than any wall if pixels
/// are small.
cv::Mat bare_surface(const cv::Mat& in, const cv::Mat& bare, double pixel_mm) {
  cv::Mat rim;
  const int thin_px = std::max(1, static_cast<int>(kThinMm / pixel_mm));
  cv::dilate(~in, rim,
             cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * thin_px + 1, 2 * thin_px + 1}),
             {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  rim &= bare;
  cv::Mat ids;
  cv::Mat stats;
  cv::Mat centroids;
  const int count = cv::connectedComponentsWithStats(rim, ids, stats, centroids, 8);
  cv::Mat longer = cv::Mat::zeros(in.size(), CV_8U);
  for (int id = 1; id < count; ++id) {
    const double length_px =
        std::hypot(stats.at<int>(id, cv::CC_STAT_WIDTH), stats.at<int>(id, cv::CC_STAT_HEIGHT));
    if (length_px * pixel_mm >= kLeastBareMm) longer |= ids == id;
  }
  cv::dilate(
      longer, longer,
      cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * kLevelBandPx + 1, 2 * kLevelBandPx + 1}));
  return longer;
}

/// Of a slice and its neighbours, into `level` where enough voxels tell it. They lie farther off
/// than those that told it: where they are of another tissue, the level stays.
void put_whole(const WindowSums& sums, const std::vector<cv::Rect>& parts, int k, double contrast,
               cv::Mat& level) {
  cv::Mat sum = cv::Mat::zeros(level.size(), CV_32F);
  cv::Mat weight = cv::Mat::zeros(level.size(), CV_32F);
  const int last = static_cast<int>(sums.weight.size()) - 1;
  for (int n = std::max(0, k - 1); n <= std::min(last, k + 1); ++n) {
    const auto at = static_cast<std::size_t>(n);
    sum += framed(sums.pixels[at], parts[at], parts[static_cast<std::size_t>(k)]);
    weight += framed(sums.weight[at], parts[at], parts[static_cast<std::size_t>(k)]);
  }
  const cv::Mat mean = sum / cv::max(weight, 1e-6);
  mean.copyTo(level, (weight >= kLeastCore) & (cv::abs(mean - level) <= contrast));
}

}  // namespace

cv::Mat framed(const cv::Mat& image, const cv::Rect& part, const cv::Rect& wanted) {
  if (part == wanted) return image;
  const cv::Rect both = part & wanted;
  if (both == wanted) return image(wanted - part.tl());
  cv::Mat out = cv::Mat::zeros(wanted.size(), image.type());
  if (!both.empty()) image(both - part.tl()).copyTo(out(both - wanted.tl()));
  return out;
}

std::vector<cv::Mat> whole_voxels(const std::vector<cv::Mat>& mask,
                                  const std::vector<cv::Rect>& parts) {
  std::vector<cv::Mat> out(mask.size());
  for (std::size_t k = 0; k < mask.size(); ++k) {
    if (parts[k].empty()) continue;
    cv::erode(mask[k], out[k], cross(), {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar(255));
    if (k > 0) out[k] &= framed(mask[k - 1], parts[k - 1], parts[k]);
    if (k + 1 < mask.size()) out[k] &= framed(mask[k + 1], parts[k + 1], parts[k]);
  }
  return out;
}

WindowSums::WindowSums(const std::vector<cv::Mat>& image, const std::vector<cv::Mat>& mask,
                       const cv::Size& window) {
  for (std::size_t k = 0; k < image.size(); ++k) {
    if (mask[k].empty() || cv::countNonZero(mask[k]) == 0) {
      pixels.push_back(cv::Mat::zeros(mask[k].size(), CV_32F));
      weight.push_back(cv::Mat::zeros(mask[k].size(), CV_32F));
      continue;
    }
    cv::Mat indicator;
    mask[k].convertTo(indicator, CV_32F, 1.0 / 255.0);
    cv::Mat sum;
    cv::boxFilter(image[k].mul(indicator), sum, CV_32F, window, {-1, -1}, true,
                  cv::BORDER_ISOLATED);
    cv::boxFilter(indicator, indicator, CV_32F, window, {-1, -1}, true, cv::BORDER_ISOLATED);
    pixels.push_back(sum);
    weight.push_back(indicator);
  }
}

int level_reach_px(const Grid& grid) {
  const cv::Size window = window_of(grid);
  return std::max(window.width, window.height) / 2;
}

LevelFinder::LevelFinder(const BoundaryInput& input, const std::vector<cv::Rect>& parts)
    : input_(input), parts_(parts), window_(window_of(input.grid)) {
  const Grid& grid = input.grid;
  const bool thin = !are_thick_slices(grid.spacing_mm()[2]);
  pixels_.resize(parts.size());
  std::vector<cv::Mat> inner(parts.size());
  std::vector<cv::Mat> outer(parts.size());
  for (int k = 0; k < grid.size[2]; ++k) {
    const auto at = static_cast<std::size_t>(k);
    if (parts[at].empty()) continue;
    pixels_[at] = slice_of(grid, input.image, k)(parts[at]);
    if (!thin) continue;
    const cv::Mat in = slice_of(grid, input.inside, k)(parts[at]) != 0;
    inner[at] = in & (slice_of(grid, input.tells_inner, k)(parts[at]) != 0);
    outer[at] = ~in & (slice_of(grid, input.tells_outer, k)(parts[at]) != 0);
  }
  if (!thin) return;
  inner_.emplace(pixels_, whole_voxels(inner, parts), window_);
  outer_.emplace(pixels_, whole_voxels(outer, parts), window_);
}

SideLevels LevelFinder::levels(int k) const {
  const Grid& grid = input_.grid;
  const cv::Mat& pixels = pixels_[static_cast<std::size_t>(k)];
  const cv::Rect& part = parts_[static_cast<std::size_t>(k)];
  const cv::Mat in = slice_of(grid, input_.inside, k)(part) != 0;
  const cv::Mat told = slice_of(grid, input_.tells_inner, k)(part) != 0;
  const cv::Mat told_outer = slice_of(grid, input_.tells_outer, k)(part) != 0;
  // Levels are told by voxels that are whole: one pixel or more off the boundary; thin walls have
  // none, there the boundary's own inner pixels must do.
  cv::Mat core;
  cv::erode(in, core, cross(), {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar(255));
  core &= told;
  cv::Mat grown;
  cv::dilate(in, grown, cross());
  SideLevels out;
  cv::Mat inner_weight;
  out.inner = masked_mean(pixels, core, window_, inner_weight);
  cv::Mat thin_weight;
  const cv::Mat thin = masked_mean(pixels, in & told, window_, thin_weight);
  thin.copyTo(out.inner, inner_weight < kLeastCore);
  cv::Mat outer_weight;
  out.outer = masked_mean(pixels, ~grown & told_outer, window_, outer_weight);
  cv::Mat any_weight;
  const cv::Mat any = masked_mean(pixels, ~grown, window_, any_weight);
  const cv::Mat few = outer_weight < kLeastCore;
  any.copyTo(out.outer, few);
  any_weight.copyTo(outer_weight, few);
  // A leaning surface passes through more than a pixel of a slice.
  if (inner_) put_whole(*inner_, parts_, k, input_.contrast, out.inner);
  if (outer_) put_whole(*outer_, parts_, k, input_.contrast, out.outer);
  if (input_.bare != nullptr) put_bare(k, in, out, thin_weight);
  out.told = (thin_weight > 0) & (outer_weight > kLeastOutside) &
             (cv::abs(out.inner - out.outer) > input_.contrast);
  return out;
}

void LevelFinder::put_bare(int k, const cv::Mat& in, SideLevels& levels,
                           cv::Mat& inner_weight) const {
  const Vec3 spacing = input_.grid.spacing_mm();
  const cv::Mat bare =
      slice_of(input_.grid, *input_.bare, k)(parts_[static_cast<std::size_t>(k)]) != 0;
  cv::Mat core;
  cv::erode(bare, core, cross(), {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  cv::Mat weight;
  const cv::Mat mean = masked_mean(pixels_[static_cast<std::size_t>(k)], core, window_, weight);
  const cv::Mat tells =
      bare_surface(in, bare, std::sqrt(spacing[0] * spacing[1])) & (weight >= kLeastCore);
  mean.copyTo(levels.inner, tells);
  inner_weight.setTo(cv::Scalar(1), tells);
}

}  // namespace beatlas::edges
