#include "pipeline/segment/boundary.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <opencv2/imgproc.hpp>

#include "pipeline/segment/chambers.h"

namespace beatlas::segment {
namespace {

constexpr float kBandPx = 2.0F;        ///< where intensity is asked, on both sides
constexpr double kAlongPx = 1.5;       ///< Gaussian along the outline
constexpr float kMostShiftPx = 1.25F;  ///< labels are no farther off than this
constexpr float kLeastAlong = 0.02F;   ///< outline, weighted, that has to be told of a place
constexpr double kUntoldPx = 0.625;    ///< standard deviation where no intensity tells the place
constexpr double kOfMisfit = 1.0;      ///< [px2] of the place's variance, for the misfit's
constexpr double kFloorPx = 0.05;      ///< what no fit tells of
constexpr float kLeastCore = 0.03F;    ///< share of the window that has to tell a level
constexpr double kLeastAcross = 0.35;  ///< a surface along the slices is known by its neighbours
constexpr double kLeastBareMm = 8;     ///< a shorter stretch without a wall is a wall not resolved
constexpr double kThinMm = 2.2;        ///< from blood to the outside: no wall is as thin
constexpr double kWindowMm = 3.5;      ///< half width of the window that tells a side's level

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
  const int reach = static_cast<int>(std::ceil(kBandPx)) + 1;
  cv::dilate(longer, longer,
             cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * reach + 1, 2 * reach + 1}));
  return longer;
}

/// Signed distance [pixels] to the outline of a mask, negative inside, smoothed a little: the
/// outline of pixels is a staircase, that of a heart is not.
cv::Mat outline_distance_px(const cv::Mat& mask) {
  cv::Mat inward;
  cv::Mat outward;
  cv::distanceTransform(mask, inward, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  cv::distanceTransform(~mask, outward, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  cv::Mat distance = outward - inward;
  distance.forEach<float>([](float& d, const int*) { d -= std::copysign(0.5F, d); });
  cv::GaussianBlur(distance, distance, {0, 0}, 1.0);
  return distance;
}

/// outline_distance_px of a part of every slice; empty where it lies inside or outside as a whole.
std::vector<cv::Mat> outline_distances_px(const Grid& grid, const std::vector<std::uint8_t>& inside,
                                          const cv::Rect& part) {
  std::vector<cv::Mat> out(static_cast<std::size_t>(grid.size[2]));
  for (int k = 0; k < grid.size[2]; ++k) {
    const cv::Mat in = slice_of(grid, inside, k)(part) != 0;
    const int within = cv::countNonZero(in);
    if (within > 0 && within < in.rows * in.cols) {
      out[static_cast<std::size_t>(k)] = outline_distance_px(in);
    }
  }
  return out;
}

/// What a way in the plane of a slice, across the outline, is along the surface's normal: the
/// outline's way from slice to slice tells how the surface leans.
double along_normal(const std::vector<cv::Mat>& distances_px, int k, int j, int i,
                    double pixel_per_slice) {
  const auto at = [&](int slice) -> std::optional<float> {
    if (slice < 0 || slice >= static_cast<int>(distances_px.size())) return {};
    const cv::Mat& distance = distances_px[static_cast<std::size_t>(slice)];
    if (distance.empty()) return {};
    return distance.at<float>(j, i);
  };
  const std::optional<float> below = at(k - 1);
  const std::optional<float> above = at(k + 1);
  const float here = *at(k);
  const int steps = (below ? 1 : 0) + (above ? 1 : 0);
  if (steps == 0) return 1;
  const double lean = static_cast<double>(above.value_or(here) - below.value_or(here)) / steps;
  return std::max(kLeastAcross, 1 / std::hypot(1.0, lean * pixel_per_slice));
}

}  // namespace

std::vector<float> outline_coverage(const Grid& grid, const std::vector<std::uint8_t>& inside) {
  std::vector<float> coverage(inside.size());
  for (int k = 0; k < grid.size[2]; ++k) {
    const cv::Mat in = slice_of(grid, inside, k) != 0;
    cv::Mat out = slice_of(grid, coverage, k);
    in.convertTo(out, CV_32F, 1.0 / 255.0);
    const int within = cv::countNonZero(in);
    if (within == 0 || within == in.rows * in.cols) continue;
    const cv::Mat covered = 0.5F - outline_distance_px(in);
    out = cv::min(cv::max(covered, 0.0F), 1.0F);  // assigns into `coverage`: same size and type
  }
  return coverage;
}

Boundary find_boundary(const BoundaryInput& input) {
  const Grid& grid = input.grid;
  Boundary found;
  found.coverage.resize(input.image.size());
  const Vec3 spacing = grid.spacing_mm();
  const double pixel_mm = std::sqrt(spacing[0] * spacing[1]);
  const cv::Size window(2 * std::max(2, static_cast<int>(std::lround(kWindowMm / spacing[0]))) + 1,
                        2 * std::max(2, static_cast<int>(std::lround(kWindowMm / spacing[1]))) + 1);
  const cv::Mat cross = cv::getStructuringElement(cv::MORPH_CROSS, {3, 3});
  // The band along the outlines, what its levels are told by, and what its distance is smoothed by.
  const int room = 16 + std::max(window.width, window.height);
  cv::Rect part;
  for (int k = 0; k < grid.size[2]; ++k) part |= rect_around(slice_of(grid, input.inside, k), room);
  if (part.empty()) return found;
  const std::vector<cv::Mat> distances_px = outline_distances_px(grid, input.inside, part);
  for (int k = 0; k < grid.size[2]; ++k) {
    const cv::Mat pixels = slice_of(grid, input.image, k)(part);
    const cv::Mat in = slice_of(grid, input.inside, k)(part) != 0;
    const cv::Mat told = slice_of(grid, input.tells_inner, k)(part) != 0;
    const cv::Mat told_outer = slice_of(grid, input.tells_outer, k)(part) != 0;
    cv::Mat out = slice_of(grid, found.coverage, k)(part);
    in.convertTo(out, CV_32F, 1.0 / 255.0);
    if (distances_px[static_cast<std::size_t>(k)].empty()) continue;

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
    thin.copyTo(inner, inner_weight < kLeastCore);
    if (input.bare != nullptr) {
      const cv::Mat bare = slice_of(grid, *input.bare, k)(part) != 0;
      cv::Mat bare_core;
      cv::erode(bare, bare_core, cross, {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
      cv::Mat bare_weight;
      const cv::Mat mean = masked_mean(pixels, bare_core, window, bare_weight);
      const cv::Mat tells = bare_surface(in, bare, pixel_mm) & (bare_weight >= kLeastCore);
      mean.copyTo(inner, tells);
      thin_weight.setTo(cv::Scalar(1), tells);
    }
    cv::Mat outer_weight;
    cv::Mat outer = masked_mean(pixels, ~grown & told_outer, window, outer_weight);
    cv::Mat any_weight;
    const cv::Mat any = masked_mean(pixels, ~grown, window, any_weight);
    const cv::Mat few = outer_weight < kLeastCore;
    any.copyTo(outer, few);
    any_weight.copyTo(outer_weight, few);

    // Geometry first: coverage g of the mask's own smooth outline. Intensity then tells by how much
    // that outline must move: across the boundary the excess of measured coverage over g adds up to
    // the shift, in pixels. Averaged along the outline, so that noise and single odd pixels cancel.
    const cv::Mat& distance_px = distances_px[static_cast<std::size_t>(k)];
    cv::Mat geometric = 0.5F - distance_px;
    geometric = cv::min(cv::max(geometric, 0.0F), 1.0F);
    cv::Mat excess = cv::Mat::zeros(out.size(), CV_32F);
    cv::Mat trusted = cv::Mat::zeros(out.size(), CV_32F);
    cv::Mat variance = cv::Mat::zeros(out.size(), CV_32F);  // of `excess`, by the image's noise
    for (int j = 0; j < out.rows; ++j) {
      for (int i = 0; i < out.cols; ++i) {
        const float d = distance_px.at<float>(j, i);
        if (std::abs(d) > kBandPx) continue;
        const float difference = inner.at<float>(j, i) - outer.at<float>(j, i);
        if (thin_weight.at<float>(j, i) <= 0 || outer_weight.at<float>(j, i) <= 0.02F ||
            std::abs(difference) <= input.contrast) {
          continue;
        }
        const float measured =
            std::clamp((pixels.at<float>(j, i) - outer.at<float>(j, i)) / difference, 0.0F, 1.0F);
        // A dark spot inside was taken in on purpose (papillary muscle): it says nothing.
        if (d < 0 && measured < 0.2F) continue;
        trusted.at<float>(j, i) = 1;
        excess.at<float>(j, i) = measured - geometric.at<float>(j, i);
        // What is beyond a level counts as that level, noise and all.
        const float noise_here = static_cast<float>(input.noise) / difference;
        variance.at<float>(j, i) = measured > 0 && measured < 1 ? noise_here * noise_here : 0.0F;
      }
    }
    cv::Mat dx;
    cv::Mat dy;
    cv::Sobel(geometric, dx, CV_32F, 1, 0, 1, 0.5);
    cv::Sobel(geometric, dy, CV_32F, 0, 1, 1, 0.5);
    cv::Mat length;
    cv::magnitude(dx, dy, length);
    cv::Mat moved;
    cv::Mat along;
    cv::GaussianBlur(excess, moved, {0, 0}, kAlongPx, kAlongPx, cv::BORDER_ISOLATED);
    cv::GaussianBlur(length.mul(trusted), along, {0, 0}, kAlongPx, kAlongPx, cv::BORDER_ISOLATED);
    cv::Mat shift_px = cv::Mat::zeros(out.size(), CV_32F);
    cv::Mat misfit = cv::Mat::zeros(out.size(), CV_32F);
    for (int j = 0; j < out.rows; ++j) {
      for (int i = 0; i < out.cols; ++i) {
        const float d = distance_px.at<float>(j, i);
        if (std::abs(d) > kBandPx + kMostShiftPx) continue;
        const float weight = along.at<float>(j, i);
        const float shift = weight > kLeastAlong ? std::clamp(moved.at<float>(j, i) / weight,
                                                              -kMostShiftPx, kMostShiftPx)
                                                 : 0.0F;
        shift_px.at<float>(j, i) = shift;
        const float covered = std::clamp(0.5F - d + shift, 0.0F, 1.0F);
        out.at<float>(j, i) = covered;
        if (trusted.at<float>(j, i) > 0) {
          const float off = excess.at<float>(j, i) + geometric.at<float>(j, i) - covered;
          misfit.at<float>(j, i) = off * off;
        }
      }
    }

    // The square of a Gaussian is a narrower one.
    constexpr double kNarrowPx = kAlongPx / std::numbers::sqrt2;
    constexpr double kOfSquare = 1 / (4 * std::numbers::pi * kAlongPx * kAlongPx);
    misfit -= variance;
    cv::GaussianBlur(variance, variance, {0, 0}, kNarrowPx, kNarrowPx, cv::BORDER_ISOLATED);
    cv::GaussianBlur(misfit, misfit, {0, 0}, kAlongPx, kAlongPx, cv::BORDER_ISOLATED);
    for (int j = 0; j < out.rows; ++j) {
      for (int i = 0; i < out.cols; ++i) {
        const float covered = out.at<float>(j, i);
        if (!(covered > 0 && covered < 1)) continue;
        const double weight = along.at<float>(j, i);
        double sigma_px = kUntoldPx;
        if (weight > kLeastAlong) {
          const double by_noise = kOfSquare * variance.at<float>(j, i) / (weight * weight);
          const double by_fit = kOfMisfit * std::max(0.0F, misfit.at<float>(j, i)) / weight;
          sigma_px = std::sqrt(by_noise + by_fit + kFloorPx * kFloorPx);
        }
        sigma_px *= along_normal(distances_px, k, j, i, pixel_mm / spacing[2]);
        found.points.push_back({static_cast<std::uint32_t>(grid.offset(part.x + i, part.y + j, k)),
                                static_cast<float>(sigma_px * pixel_mm)});
      }
    }
  }
  return found;
}

}  // namespace beatlas::segment
