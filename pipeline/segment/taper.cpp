#include "pipeline/segment/taper.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "pipeline/core/parallel.h"
#include "pipeline/core/slices.h"
#include "pipeline/segment/seeds.h"

namespace beatlas::segment {
namespace {

constexpr double kMarginMm = 2;         ///< beyond the continuation: walls are not quite convex
constexpr double kPureMm = 4;           ///< half a thick slice below the plane a slice is pure
constexpr double kPureBySightMm = 1.5;  ///< the same where views tell: slices far apart are thinner
constexpr double kRvWallMm = 3.5;       ///< muscle left about an RV that was bounded
constexpr double kLungMm = 3;  ///< radius of a dark part that is lung, not noise or a vessel
constexpr double kFarMm = 1000;

using Set = std::array<bool, 5>;  ///< [label]
constexpr Set kRv{false, true, false, false, false};
constexpr Set kLvCavity{false, false, false, true, false};
constexpr Set kLvOutside{false, false, true, true, false};
constexpr Set kLvOrRest{false, false, true, true, true};
constexpr Set kRvOrRest{false, true, false, false, true};
constexpr Set kHeart{false, true, true, true, true};

/// Labels of one phase, slice by slice.
struct Stack {
  const Grid& grid;
  std::vector<std::uint8_t>& labels;

  [[nodiscard]] cv::Mat slice(int k) const { return slice_of(grid, labels, k); }
  [[nodiscard]] bool has(int k) const { return k >= 0 && k < grid.size[2]; }
  [[nodiscard]] cv::Mat mask(int k, const Set& set) const {
    cv::Mat out = cv::Mat::zeros(grid.size[1], grid.size[0], CV_8U);
    for (std::size_t label = 0; label < set.size(); ++label) {
      if (set[label]) out |= slice(k) == static_cast<int>(label);
    }
    return out;
  }
  /// Distance to the outline of a set [mm], negative inside; far without one.
  [[nodiscard]] cv::Mat distance(int k, const Set& set) const {
    const cv::Mat in = mask(k, set);
    if (cv::countNonZero(in) == 0) return {in.size(), CV_32F, cv::Scalar(kFarMm)};
    cv::Mat outward;
    cv::Mat inward;
    cv::distanceTransform(~in, outward, cv::DIST_L2, cv::DIST_MASK_PRECISE);
    cv::distanceTransform(in, inward, cv::DIST_L2, cv::DIST_MASK_PRECISE);
    const Vec3 spacing = grid.spacing_mm();
    return (outward - inward) * std::sqrt(spacing[0] * spacing[1]);
  }
  /// Straight continuation into slice k of the next two on the side of `from`; never wider than the
  /// next one. Far everywhere if the next one has none.
  [[nodiscard]] cv::Mat continued(int k, int from, const Set& set) const {
    const cv::Mat next = distance(k + from, set);
    if (!has(k + 2 * from)) return next;
    const cv::Mat second = distance(k + 2 * from, set);
    if (second.at<float>(0, 0) >= kFarMm) return next;
    return cv::max(2 * next - second, next);
  }
  /// How far a set moves from one slice to the next on the way from `from` to slice k.
  [[nodiscard]] cv::Mat lean(int k, int from, const Set& set) const {
    const cv::Moments next = cv::moments(mask(k + from, set), true);
    const cv::Moments second = cv::moments(mask(k + 2 * from, set), true);
    cv::Mat move = cv::Mat::eye(2, 3, CV_64F);
    if (next.m00 > 0 && second.m00 > 0) {
      move.at<double>(0, 2) = next.m10 / next.m00 - second.m10 / second.m00;
      move.at<double>(1, 2) = next.m01 / next.m00 - second.m01 / second.m00;
    }
    return move;
  }
  /// The set of the slice beside, moved.
  [[nodiscard]] cv::Mat carried(int k, int from, const Set& set, const cv::Mat& move) const {
    cv::Mat out;
    cv::warpAffine(mask(k + from, set), out, move, {grid.size[0], grid.size[1]}, cv::INTER_NEAREST);
    return out;
  }
};

/// What of a slice is lung or air whatever its neighbours show.
cv::Mat lung(const ImageCycle<float>& images, const Chambers& chambers, std::size_t phase, int k,
             const cv::Mat& labels) {
  const Vec3 spacing = images.grid.spacing_mm();
  cv::Mat dark = slice_of(images.grid, images.phases[phase], k) < chambers.levels.dark;
  dark &= labels == kLabelBackground;
  cv::morphologyEx(dark, dark, cv::MORPH_OPEN, disc(kLungMm, {spacing[0], spacing[1]}));
  return dark;
}

/// Redraws each ventricle in the slice whose centre lies from `least_mm` to `most_mm` below the
/// plane.
void redraw(const ImageCycle<float>& images, const Chambers& chambers, const VentricleEnds& ends,
            double least_mm, double most_mm, double unseen_mm, ImageCycle<std::uint8_t>& labels) {
  if (!chambers.found_lv() || labels.grid.spacing_mm()[2] < kThickSlicesMm) return;
  const int up = chambers.base_step;
  const double slice_mm = labels.grid.spacing_mm()[2];
  const auto slice_at = [&](const std::optional<std::vector<double>>& planes, std::size_t p) {
    if (!planes) return -1;
    const auto k = static_cast<int>(std::lround((*planes)[p]));
    const double below_mm = up * ((*planes)[p] - k) * slice_mm;
    const bool seen = std::any_of(chambers.lv.begin(), chambers.lv.end(),
                                  [&](const LvSlice& slice) { return slice.k == k; });
    const bool wanted = below_mm >= least_mm && below_mm < (seen ? most_mm : unseen_mm);
    return wanted && k >= 0 && k < labels.grid.size[2] ? k : -1;
  };
  parallel_for(labels.phases.size(), [&](std::size_t p) {
    const Stack stack{labels.grid, labels.phases[p]};
    if (const int k = slice_at(ends.lv, p); k >= 0 && stack.has(k - 2 * up)) {
      cv::Mat slice = stack.slice(k);
      const cv::Mat move = stack.lean(k, -up, kLvOutside);
      const cv::Mat outside =
          stack.carried(k, -up, kLvOutside, move) & ~lung(images, chambers, p, k, slice);
      const cv::Mat cavity = stack.carried(k, -up, kLvCavity, move);
      slice.setTo(cv::Scalar(kLabelRestOfHeart), stack.mask(k, kLvOutside));
      slice.setTo(cv::Scalar(kLabelLvMyocardium), outside);
      slice.setTo(cv::Scalar(kLabelLvBlood), outside & cavity);
    }
    if (const int k = slice_at(ends.rv, p); k >= 0 && stack.has(k - 2 * up)) {
      cv::Mat slice = stack.slice(k);
      const cv::Mat rv = stack.carried(k, -up, kRv, stack.lean(k, -up, kLvOutside)) &
                         ~lung(images, chambers, p, k, slice);
      slice.setTo(cv::Scalar(kLabelRestOfHeart), stack.mask(k, kRv));
      slice.setTo(cv::Scalar(kLabelRvBlood), rv & ~stack.mask(k, kLvOutside));
    }
  });
}

}  // namespace

void bound_apex(const Chambers& chambers, ImageCycle<std::uint8_t>& labels) {
  if (!chambers.found_lv() || labels.grid.spacing_mm()[2] < kThickSlicesMm) return;
  const int up = chambers.base_step;
  const int apical = up > 0 ? chambers.lv.front().k : chambers.lv.back().k;
  parallel_for(labels.phases.size(), [&](std::size_t p) {
    const Stack stack{labels.grid, labels.phases[p]};
    for (int k = apical; stack.has(k); k -= up) {
      cv::Mat slice = stack.slice(k);
      if (k != apical) {
        slice.setTo(cv::Scalar(kLabelLvMyocardium), slice == kLabelLvBlood);
      }
      slice.setTo(cv::Scalar(kLabelBackground), stack.continued(k, up, kHeart) > kMarginMm);
      const cv::Mat rv = stack.mask(k, kRv);
      if (cv::countNonZero(rv) == 0) continue;
      const cv::Mat bound = stack.continued(k, up, kRv);
      const cv::Mat beyond = rv & (bound > kMarginMm);
      slice.setTo(cv::Scalar(kLabelRestOfHeart), beyond);
      const cv::Mat outside = stack.distance(k, kRv) > kRvWallMm;
      slice.setTo(cv::Scalar(kLabelBackground), beyond & outside);
    }
  });
}

void clear_mixed_atria(const Chambers& chambers, const VentricleEnds& ends,
                       ImageCycle<std::uint8_t>& labels) {
  if (!chambers.found_lv() || ends.from_views) return;
  const int up = chambers.base_step;
  parallel_for(labels.phases.size(), [&](std::size_t p) {
    const Stack stack{labels.grid, labels.phases[p]};
    const auto clear = [&](const std::optional<std::vector<double>>& planes, const Set& set) {
      if (!planes) return;
      const auto k = static_cast<int>(std::lround((*planes)[p]));
      if (up * ((*planes)[p] - k) >= 0 || !stack.has(k) || !stack.has(k + up)) return;
      cv::Mat slice = stack.slice(k);
      slice.setTo(cv::Scalar(kLabelBackground), stack.mask(k, set) & ~stack.mask(k + up, kHeart));
    };
    clear(ends.lv, kLvOrRest);
    clear(ends.rv, kRvOrRest);
  });
}

ImageCycle<std::uint8_t> continued_to_base(const ImageCycle<float>& images,
                                           const Chambers& chambers, const VentricleEnds& ends,
                                           const ImageCycle<std::uint8_t>& labels) {
  ImageCycle<std::uint8_t> out = labels;
  const double slice_mm = labels.grid.spacing_mm()[2];
  redraw(images, chambers, ends, -slice_mm, 0, 0, out);
  return out;
}

void redraw_mixed_slices(const ImageCycle<float>& images, const Chambers& chambers,
                         const VentricleEnds& ends, ImageCycle<std::uint8_t>& labels) {
  redraw(images, chambers, ends, 0, ends.from_views ? kPureBySightMm : kPureMm,
         labels.grid.spacing_mm()[2], labels);
}

}  // namespace beatlas::segment
