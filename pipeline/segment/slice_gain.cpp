#include "pipeline/segment/slice_gain.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "pipeline/core/slices.h"
#include "pipeline/segment/chambers.h"
#include "pipeline/segment/tissue.h"

namespace beatlas::segment {
namespace {

constexpr double kLeastStep = 0.08;  ///< of a gain's logarithm from slice to slice, to be one
constexpr double kMostGain = 0.4;    ///< of its logarithm
constexpr double kSignal = 0.5;      ///< of muscle: darker voxels show no gain
constexpr double kInBlood = 0.6;     ///< of the cavity's radius
constexpr std::size_t kFewest = 100;

double middle_of(std::vector<double>& values) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

struct Levels {
  double blood = 0;
  double muscle = 0;
};

/// Of the LV in one slice, in all phases.
Levels levels_of(const ImageCycle<float>& images, const LvSlice& slice) {
  const Vec3 spacing = images.grid.spacing_mm();
  const cv::Point2d pixel_mm(spacing[0], spacing[1]);
  std::vector<double> blood;
  std::vector<double> muscle;
  for (std::size_t p = 0; p < images.phases.size(); ++p) {
    const cv::Mat image = slice_of(images.grid, images.phases[p], slice.k);
    const Ring& ring = slice.rings[p];
    const auto add = [&](int a, double radius_mm, std::vector<double>& to) {
      const cv::Point2d at = ray_point(slice.centre_px, pixel_mm, a, radius_mm);
      const cv::Point px(static_cast<int>(std::lround(at.x)), static_cast<int>(std::lround(at.y)));
      if (!cv::Rect({0, 0}, image.size()).contains(px)) return;
      to.push_back(static_cast<double>(image.at<float>(px)));
    };
    for (int a = 0; a < Ring::kRays; ++a) {
      const auto i = static_cast<std::size_t>(a);
      if (!ring.walled[i]) continue;
      add(a, kInBlood * ring.endo_mm[i], blood);
      add(a, 0.5 * (ring.endo_mm[i] + ring.outer_mm[i]), muscle);
    }
  }
  if (blood.size() < kFewest || muscle.size() < kFewest) return {};
  return {middle_of(blood), middle_of(muscle)};
}

/// The least that both have in common.
double common(double a, double b) {
  if (a * b <= 0) return 0;
  return a > 0 ? std::min(a, b) : std::max(a, b);
}

/// Middle of the shortest stretch that holds a third of the values: where most agree.
double most_common(std::vector<double>& values) {
  std::sort(values.begin(), values.end());
  const std::size_t third = values.size() / 3;
  std::size_t best = 0;
  for (std::size_t at = 0; at + third < values.size(); ++at) {
    if (values[at + third] - values[at] < values[best + third] - values[best]) best = at;
  }
  return values[best + third / 2];
}

/// Logarithm of how much brighter slice `to` is than `from`, voxel by voxel: what goes on from one
/// into the other tells the gain.
double step_between(const ImageCycle<float>& images, int from, int to, double least) {
  std::vector<double> steps;
  const std::size_t a = images.grid.offset(0, 0, from);
  const std::size_t b = images.grid.offset(0, 0, to);
  for (const std::vector<float>& phase : images.phases) {
    for (std::size_t v = 0; v < images.grid.slice_count(); v += 3) {
      const auto here = static_cast<double>(phase[a + v]);
      const auto there = static_cast<double>(phase[b + v]);
      if (here > least && there > least) steps.push_back(std::log(there / here));
    }
  }
  return steps.size() < kFewest ? 0 : most_common(steps);
}

}  // namespace

std::vector<double> slice_gains(const ImageCycle<float>& images) {
  if (images.grid.spacing_mm()[2] < kThickSlicesMm) return {};
  StageContext quiet;
  const Chambers chambers = find_chambers(images, temporal_stats(images), quiet);
  if (!chambers.found_lv()) return {};
  std::vector<double> blood;
  std::vector<double> muscle;
  std::vector<Levels> levels;
  for (const LvSlice& slice : chambers.lv) {
    levels.push_back(levels_of(images, slice));
    if (!(levels.back().muscle > 0) || !(levels.back().blood > levels.back().muscle)) continue;
    blood.push_back(levels.back().blood);
    muscle.push_back(levels.back().muscle);
  }
  if (blood.size() < 3) return {};
  const Levels usual{middle_of(blood), middle_of(muscle)};
  std::vector<double> gain(static_cast<std::size_t>(images.grid.size[2]), 0);
  double most = 0;
  for (std::size_t s = 0; s < levels.size(); ++s) {
    if (!(levels[s].muscle > 0) || !(levels[s].blood > 0)) continue;
    const double common_gain =
        common(std::log(levels[s].blood / usual.blood), std::log(levels[s].muscle / usual.muscle));
    gain[static_cast<std::size_t>(chambers.lv[s].k)] =
        std::clamp(common_gain, -kMostGain, kMostGain);
    if (s == 0) continue;
    most = std::max(most, std::abs(gain[static_cast<std::size_t>(chambers.lv[s].k)] -
                                   gain[static_cast<std::size_t>(chambers.lv[s - 1].k)]));
  }
  if (most < kLeastStep) return {};
  const double least = kSignal * usual.muscle;
  const auto carry_on = [&](int from, int step) {
    for (int k = from + step; k >= 0 && k < images.grid.size[2]; k += step) {
      const double next =
          gain[static_cast<std::size_t>(k - step)] + step_between(images, k - step, k, least);
      gain[static_cast<std::size_t>(k)] = std::clamp(next, -kMostGain, kMostGain);
    }
  };
  carry_on(chambers.lv.front().k, -1);
  carry_on(chambers.lv.back().k, 1);
  for (double& value : gain) value = std::exp(value);
  return gain;
}

ImageCycle<float> without_slice_gains(ImageCycle<float> images, const std::vector<double>& gains) {
  if (gains.empty()) return images;
  for (std::vector<float>& phase : images.phases) {
    for (std::size_t v = 0; v < phase.size(); ++v) {
      phase[v] /= static_cast<float>(gains[v / images.grid.slice_count()]);
    }
  }
  return images;
}

}  // namespace beatlas::segment
