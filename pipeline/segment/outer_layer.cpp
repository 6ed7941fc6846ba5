#include "pipeline/segment/outer_layer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include <opencv2/imgproc.hpp>

#include "pipeline/core/parallel.h"
#include "pipeline/core/slices.h"
#include "pipeline/segment/distance_map.h"
#include "pipeline/segment/segment.h"

namespace beatlas::segment {
namespace {

constexpr int kRays = 64;             ///< directions from the LV's middle, in a slice
constexpr double kLayerMm = 0.75;     ///< thickness of a layer
constexpr int kLayers = 32;           ///< away from the cavity
constexpr double kPatchMm = 4.0;      ///< Gaussian over which a layer is averaged
constexpr double kBesideMm = 3.0;     ///< so near the RV or the rest of the heart a wall is shared
constexpr double kMixedMm = 1.5;      ///< next to the cavity voxels hold blood
constexpr double kLeastWallMm = 4.0;  ///< of muscle that stays
constexpr int kEdgeLayers = 2;        ///< the outermost are mixed with what lies beyond
constexpr double kLeastStep = 0.15;   ///< of the way from muscle to blood
constexpr double kRagMm = 2.0;        ///< radius that a rag does not hold
constexpr double kCutSigmaMm = 2.0;   ///< smooths the outline where something was cut off
constexpr int kAround = 3;            ///< directions on both sides that have to agree
constexpr double kSure = 4;           ///< standard deviations that the step stands out by
constexpr double kLeastNoise = 0.01;  ///< of the contrast: so even is no tissue
constexpr double kLeastCount = 0.5;   ///< voxels, weighted, that tell a layer
constexpr double kPastCavity = 0.5;   ///< slices by which a cavity goes on past its last one
constexpr float kNowhere = std::numeric_limits<float>::infinity();

/// Sums over voxels by slice, direction and layer.
struct Profiles {
  explicit Profiles(int slices) {
    for (int layer = 0; layer < kLayers; ++layer) {
      sum.emplace_back(cv::Mat::zeros(slices, kRays, CV_32F));
      count.emplace_back(cv::Mat::zeros(slices, kRays, CV_32F));
    }
  }
  std::vector<cv::Mat> sum;  ///< [layer](slice, direction)
  std::vector<cv::Mat> count;
};

/// Gaussian over directions (a circle) and slices; keeps the sum of weights in units of voxels.
void smooth(std::vector<cv::Mat>& layers, double rays_sigma, double slices_sigma) {
  const int wrap = kRays / 2;
  for (cv::Mat& layer : layers) {
    cv::Mat wide;
    cv::copyMakeBorder(layer, wide, 0, 0, wrap, wrap, cv::BORDER_WRAP);
    // OpenCV takes a sigma of 0 for "as the other": a tiny one leaves slices alone.
    cv::GaussianBlur(wide, wide, {0, 0}, std::max(rays_sigma, 1e-3), std::max(slices_sigma, 1e-3),
                     cv::BORDER_ISOLATED);
    const double peak = std::max(1.0, std::sqrt(2 * std::numbers::pi) * rays_sigma) *
                        std::max(1.0, std::sqrt(2 * std::numbers::pi) * slices_sigma);
    layer = wide(cv::Rect(wrap, 0, kRays, layer.rows)) * peak;
  }
}

/// Of one direction in one slice: the layers that are whole, from the first beyond the cavity's
/// rim.
struct Profile {
  std::vector<double> counts, sums, means;
  int first = 0;

  Profile(const Profiles& profiles, int k, int ray)
      : first(static_cast<int>(std::ceil(kMixedMm / kLayerMm))) {
    for (int layer = 0; layer < kLayers; ++layer) {
      const auto l = static_cast<std::size_t>(layer);
      counts.push_back(static_cast<double>(profiles.count[l].at<float>(k, ray)));
      sums.push_back(static_cast<double>(profiles.sum[l].at<float>(k, ray)));
      means.push_back(sums.back() / std::max(counts.back(), kLeastCount));
    }
    int end = kLayers;
    while (end > 0 && counts[static_cast<std::size_t>(end) - 1] < kLeastCount) --end;
    // The outermost are mixed with what lies beyond.
    const auto whole = static_cast<std::size_t>(std::max(0, end - 1 - kEdgeLayers));
    counts.resize(whole);
    sums.resize(whole);
    means.resize(whole);
  }
  [[nodiscard]] int size() const { return static_cast<int>(means.size()); }
};

/// Where a layer as bright as blood or more begins [mm from the cavity]: half-way up to it.
float edge_of_bright(const Profile& profile, const TissueLevels& levels) {
  const int from = static_cast<int>(kLeastWallMm / kLayerMm) + 1;
  if (profile.size() <= from) return kNowhere;
  const double top = *std::max_element(profile.means.begin() + from, profile.means.end());
  if (top <= levels.threshold) return kNowhere;
  const double half = 0.5 * (levels.muscle + top);
  for (int layer = from; layer < profile.size(); ++layer) {
    const auto l = static_cast<std::size_t>(layer);
    if (profile.means[l] < half) continue;
    const double below = std::min(profile.means[l - 1], half);
    const double part = (half - below) / std::max(1e-9, profile.means[l] - below);
    return static_cast<float>((layer - 0.5 + part) * kLayerMm);
  }
  return kNowhere;
}

/// Where a layer a little brighter than muscle begins: of all places that part the profile in two,
/// the one whose two means differ most surely.
float edge_of_step(const Profile& profile, const TissueLevels& levels, double noise) {
  const double contrast = levels.blood - levels.muscle;
  const double spread = std::max(noise, kLeastNoise * contrast);
  double all = 0;
  double sum = 0;
  for (int layer = profile.first; layer < profile.size(); ++layer) {
    all += profile.counts[static_cast<std::size_t>(layer)];
    sum += profile.sums[static_cast<std::size_t>(layer)];
  }
  float best = kNowhere;
  double most = kSure * kSure;
  double inner = 0;
  double inner_sum = 0;
  for (int split = profile.first + 1; split < profile.size(); ++split) {
    inner += profile.counts[static_cast<std::size_t>(split) - 1];
    inner_sum += profile.sums[static_cast<std::size_t>(split) - 1];
    const double outer = all - inner;
    if (split * kLayerMm < kLeastWallMm || inner < 1 || outer < 1) continue;
    const double rise = (sum - inner_sum) / outer - inner_sum / inner;
    if (rise < kLeastStep * contrast) continue;
    const double sure = rise * rise * inner * outer / (inner + outer) / (spread * spread);
    if (sure <= most) continue;
    most = sure;
    best = static_cast<float>(split * kLayerMm);
  }
  return best;
}

/// Where muscle ends [mm from the cavity] and something brighter begins; kNowhere if nothing does.
float end_of_muscle(const Profile& profile, const TissueLevels& levels, double noise) {
  const float bright = edge_of_bright(profile, levels);
  return bright < kNowhere ? bright : edge_of_step(profile, levels, noise);
}

/// Each direction's end as most of those around it say: one, and where, or none.
cv::Mat agreed(const cv::Mat& ends) {
  cv::Mat out(ends.size(), CV_32F, cv::Scalar(kNowhere));
  for (int k = 0; k < ends.rows; ++k) {
    for (int a = 0; a < kRays; ++a) {
      std::vector<float> around;
      for (int b = -kAround; b <= kAround; ++b) {
        const float end = ends.at<float>(k, (a + b + kRays) % kRays);
        if (end < kNowhere) around.push_back(end);
      }
      if (around.size() <= static_cast<std::size_t>(kAround)) continue;
      const auto middle = around.begin() + static_cast<std::ptrdiff_t>(around.size() / 2);
      std::nth_element(around.begin(), middle, around.end());
      out.at<float>(k, a) = *middle;
    }
  }
  return out;
}

/// Smooths a slice's LV outline after something was cut off `wall`, within what was wall before,
/// and leaves no rags.
void smooth_cut(cv::Mat& slice, const cv::Mat& wall, const cv::Point2d& pixel_mm) {
  cv::Mat whole;
  cv::morphologyEx(cv::Mat(slice != kLabelBackground), whole, cv::MORPH_OPEN,
                   disc(kRagMm, pixel_mm), {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  cv::Mat outward;
  cv::Mat inward;
  cv::distanceTransform(~whole, outward, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  cv::distanceTransform(whole, inward, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  cv::Mat distance = outward - inward;
  cv::GaussianBlur(distance, distance, {0, 0}, kCutSigmaMm / pixel_mm.x, kCutSigmaMm / pixel_mm.y);
  slice.setTo(cv::Scalar(kLabelLvMyocardium), wall & (distance < 0));
  slice.setTo(cv::Scalar(kLabelBackground), wall & (distance >= 0));
}

/// By slice: the middle of the LV, about which directions are [pixels]; none without a cavity.
using Middles = std::vector<std::optional<cv::Point2d>>;

Middles middles_of(const Grid& grid, const std::vector<std::uint8_t>& phase) {
  Middles out(static_cast<std::size_t>(grid.size[2]));
  for (std::size_t k = 0; k < out.size(); ++k) {
    const cv::Mat slice = slice_of(grid, phase, static_cast<int>(k));
    const cv::Mat blood = slice == kLabelLvBlood;
    if (cv::countNonZero(blood) == 0) continue;
    const cv::Moments shape = cv::moments(blood | (slice == kLabelLvMyocardium), true);
    out[k] = cv::Point2d(shape.m10 / shape.m00, shape.m01 / shape.m00);
  }
  return out;
}

/// The nearest slice that has a middle; without any, none.
std::optional<int> nearest_middle(const Middles& middles, int k) {
  const auto slices = static_cast<int>(middles.size());
  for (int off = 0; off < slices; ++off) {
    for (const int at : {k - off, k + off}) {
      if (at >= 0 && at < slices && middles[static_cast<std::size_t>(at)]) return at;
    }
  }
  return std::nullopt;
}

/// Beyond the cavity's last slice too little muscle is left to tell where it ends: it ends as far
/// from the cavity as in the slice before, and the cavity goes on into the gap between the two.
void carry_past_cavity(const Middles& middles, double slice_mm, cv::Mat& ends) {
  const auto carry = [&](int k, int from) {
    if (middles[static_cast<std::size_t>(k)]) return;
    const bool is_next = middles[static_cast<std::size_t>(from)].has_value();
    const auto farther = static_cast<float>(is_next ? kPastCavity * slice_mm : 0);
    for (int a = 0; a < kRays; ++a) {
      float& end = ends.at<float>(k, a);
      end = std::min(end, ends.at<float>(from, a) + farther);
    }
  };
  for (int k = 1; k < ends.rows; ++k) carry(k, k - 1);
  for (int k = ends.rows - 2; k >= 0; --k) carry(k, k + 1);
}

}  // namespace

void strip_outer_layer(const ImageCycle<float>& images, double noise, const Chambers& chambers,
                       ImageCycle<std::uint8_t>& labels) {
  if (!chambers.found_lv()) return;
  const Grid& grid = images.grid;
  const Vec3 spacing = grid.spacing_mm();
  const cv::Point2d pixel_mm(spacing[0], spacing[1]);
  const bool across = spacing[2] < kThickSlicesMm;
  parallel_for(static_cast<std::size_t>(labels.phase_count()), [&](std::size_t p) {
    std::vector<std::uint8_t>& phase = labels.phases[p];
    std::vector<std::uint8_t> cavity(phase.size());
    std::transform(phase.begin(), phase.end(), cavity.begin(), [](std::uint8_t label) {
      return static_cast<std::uint8_t>(label == kLabelLvBlood ? 255 : 0);
    });
    const std::vector<float> depth = distance_near(grid, cavity, across, kLayers * kLayerMm);
    // Of each voxel of the free wall: its direction, -1 elsewhere.
    std::vector<std::int8_t> ray(phase.size(), -1);
    Profiles profiles(grid.size[2]);
    const Middles middles = middles_of(grid, phase);
    double radius_mm = 0;
    double voxels = 0;
    for (int k = 0; k < grid.size[2]; ++k) {
      const cv::Mat slice = slice_of(grid, phase, k);
      const cv::Mat lv = (slice == kLabelLvBlood) | (slice == kLabelLvMyocardium);
      const std::optional<int> nearest = nearest_middle(middles, k);
      if (!nearest || cv::countNonZero(lv) == 0) continue;
      const cv::Point2d middle = *middles[static_cast<std::size_t>(*nearest)];
      cv::Mat shared = (slice == kLabelRvBlood) | (slice == kLabelRestOfHeart);
      cv::dilate(shared, shared, disc(kBesideMm, pixel_mm));
      const cv::Rect part = rect_around(lv, 0);
      for (int j = part.y; j < part.y + part.height; ++j) {
        for (int i = part.x; i < part.x + part.width; ++i) {
          const std::size_t v = grid.offset(i, j, k);
          if (phase[v] != kLabelLvMyocardium || shared.at<std::uint8_t>(j, i) != 0) continue;
          const auto layer = static_cast<int>(static_cast<double>(depth[v]) / kLayerMm);
          if (layer >= kLayers) continue;
          const double x = (i - middle.x) * spacing[0];
          const double y = (j - middle.y) * spacing[1];
          const double turn = std::atan2(y, x) / (2 * std::numbers::pi) + 0.5;
          const int at = std::min(kRays - 1, static_cast<int>(turn * kRays));
          ray[v] = static_cast<std::int8_t>(at);
          profiles.sum[static_cast<std::size_t>(layer)].at<float>(k, at) += images.phases[p][v];
          profiles.count[static_cast<std::size_t>(layer)].at<float>(k, at) += 1;
          radius_mm += std::hypot(x, y);
          voxels += 1;
        }
      }
    }
    if (voxels == 0) return;
    radius_mm /= voxels;
    const double rays_sigma = kPatchMm / (2 * std::numbers::pi * radius_mm / kRays);
    const double slices_sigma = across ? kPatchMm / spacing[2] : 0;
    smooth(profiles.sum, rays_sigma, slices_sigma);
    smooth(profiles.count, rays_sigma, slices_sigma);
    cv::Mat ends(grid.size[2], kRays, CV_32F);
    for (int k = 0; k < grid.size[2]; ++k) {
      for (int a = 0; a < kRays; ++a) {
        ends.at<float>(k, a) = end_of_muscle(Profile(profiles, k, a), chambers.levels, noise);
      }
    }
    ends = agreed(ends);
    if (across) carry_past_cavity(middles, spacing[2], ends);
    for (int k = 0; k < grid.size[2]; ++k) {
      cv::Mat slice = slice_of(grid, phase, k);
      const cv::Mat wall = slice == kLabelLvMyocardium;
      bool stripped = false;
      const std::size_t end = grid.offset(0, 0, k) + grid.slice_count();
      for (std::size_t v = grid.offset(0, 0, k); v < end; ++v) {
        if (ray[v] < 0 || depth[v] <= ends.at<float>(k, ray[v])) continue;
        phase[v] = kLabelBackground;
        stripped = true;
      }
      if (stripped) smooth_cut(slice, wall, pixel_mm);
    }
  });
}

}  // namespace beatlas::segment
