#include "pipeline/segment/base_plane.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include <opencv2/imgproc.hpp>

#include "pipeline/segment/chambers.h"

namespace beatlas::segment {
namespace {

constexpr std::size_t kLeastPixels = 50;  ///< of a region that tells anything
constexpr double kLeastChange = 0.2;      ///< mean square over the region, of the contrast's square
constexpr double kFirstOfChanges = 0.5;   ///< of the largest: the first one that is as large
constexpr double kTellingPixel = 0.5;     ///< a pixel's change that tells, of the contrast
constexpr double kLowerShare = 0.25;
constexpr double kMostUnexplained = 0.5;  ///< of the change: what is no mixture of the neighbours
constexpr double kFatReachMm = 12;        ///< fat so near the RV's blood lies on its wall
constexpr double kMostFatMm = 5;          ///< thicker, it is the chest's
constexpr double kLeastPhases = 0.7;

/// A slice between its neighbours in one phase, in the region of the one on the ventricle's side.
struct Step {
  double change = 0;       ///< mean square difference of the neighbours
  double unexplained = 0;  ///< mean square of what a mixture of them leaves, of the change
  double share = 0;        ///< of the ventricle in the mixture, 0..1
};

std::optional<Step> step_at(const BasePlaneSearch& s, std::size_t phase, int k,
                            const std::vector<std::uint8_t>& region) {
  const Grid& grid = s.labels.grid;
  const std::vector<float>& image = s.images.phases[phase];
  const std::size_t below = grid.offset(0, 0, k - s.base_step);
  const std::size_t here = grid.offset(0, 0, k);
  const std::size_t beyond = grid.offset(0, 0, k + s.base_step);
  std::vector<std::pair<double, double>> shares;  // share, weight
  double count = 0;
  double change = 0;
  double product = 0;
  double square = 0;
  for (std::size_t v = 0; v < grid.slice_count(); ++v) {
    const std::uint8_t label = s.labels.phases[phase][below + v];
    if (std::find(region.begin(), region.end(), label) == region.end()) continue;
    // Trabeculae of a cavity end well below its base.
    const bool blood = label == kLabelLvBlood || label == kLabelRvBlood;
    if (blood && static_cast<double>(image[below + v]) < s.threshold) continue;
    const double span = static_cast<double>(image[below + v]) - image[beyond + v];
    const double left = static_cast<double>(image[here + v]) - image[beyond + v];
    count += 1;
    change += span * span;
    product += left * span;
    square += left * left;
    if (std::abs(span) > kTellingPixel * s.contrast) {
      shares.emplace_back(left / span, std::abs(span));
    }
  }
  if (count < kLeastPixels || shares.empty()) return {};
  Step out;
  out.change = change / count;
  out.unexplained = (square - product * product / change) / change;
  std::sort(shares.begin(), shares.end());
  double all = 0;
  for (const auto& [share, weight] : shares) all += weight;
  double sum = 0;
  for (const auto& [share, weight] : shares) {
    sum += weight;
    out.share = std::clamp(share, 0.0, 1.0);
    if (sum >= kLowerShare * all) break;
  }
  return out;
}

/// Mean thickness of what is bright on the heart's outside near the region [mm].
double fat_on_wall_mm(const BasePlaneSearch& s, std::size_t phase, int k,
                      const std::vector<std::uint8_t>& region) {
  const Grid& grid = s.labels.grid;
  const cv::Mat labels = slice_of(grid, s.labels.phases[phase], k);
  const cv::Mat image = slice_of(grid, s.images.phases[phase], k);
  cv::Mat blood = cv::Mat::zeros(labels.size(), CV_8U);
  for (const std::uint8_t label : region) blood |= labels == label;
  const cv::Mat heart = labels != kLabelBackground;
  const double pixel_mm = std::sqrt(grid.spacing_mm()[0] * grid.spacing_mm()[1]);
  const auto near = [&](const cv::Mat& mask, double reach_mm) {
    cv::Mat away;
    cv::distanceTransform(~mask, away, cv::DIST_L2, cv::DIST_MASK_PRECISE);
    return cv::Mat(away * pixel_mm <= reach_mm);
  };
  const cv::Mat beside = near(blood, kFatReachMm);
  cv::Mat inner;
  cv::erode(heart, inner, cv::getStructuringElement(cv::MORPH_CROSS, {3, 3}));
  const int outline = cv::countNonZero(heart & ~inner & beside);
  const int fat =
      cv::countNonZero((image > s.threshold) & ~heart & near(heart, kMostFatMm) & beside);
  return outline > 0 ? std::min(kMostFatMm, fat * pixel_mm / outline) : 0;
}

/// Median of each value and its two neighbours in time, cyclic.
std::vector<double> without_outliers(const std::vector<double>& values) {
  const std::size_t n = values.size();
  if (n < 5) return values;
  std::vector<double> out(n);
  for (std::size_t p = 0; p < n; ++p) {
    std::array<double, 3> near{values[(p + n - 1) % n], values[p], values[(p + 1) % n]};
    std::sort(near.begin(), near.end());
    out[p] = near[1];
  }
  return out;
}

/// Straight through the gaps, cyclic. @pre one value at least is a number
std::vector<double> filled(std::vector<double> values) {
  const auto n = static_cast<int>(values.size());
  const std::vector<double> given = values;
  for (int p = 0; p < n; ++p) {
    const auto at = [&](int q) { return given[static_cast<std::size_t>(((q % n) + n) % n)]; };
    if (!std::isnan(at(p))) continue;
    int before = 1;
    int after = 1;
    while (std::isnan(at(p - before))) ++before;
    while (std::isnan(at(p + after))) ++after;
    values[static_cast<std::size_t>(p)] =
        (after * at(p - before) + before * at(p + after)) / (before + after);
  }
  return values;
}

}  // namespace

std::optional<std::vector<double>> base_plane_by_mixture(const BasePlaneSearch& search,
                                                         const std::vector<std::uint8_t>& region,
                                                         bool under_fat) {
  const int slices = search.labels.grid.size[2];
  const int step = search.base_step;
  const int last = step > 0 ? slices - 1 : 0;
  const double least = kLeastChange * search.contrast * search.contrast;
  std::vector<double> planes;
  std::vector<double> fat_mm;
  int told = 0;
  bool inside = false;
  for (std::size_t p = 0; p < search.labels.phases.size(); ++p) {
    std::vector<std::pair<int, Step>> steps;
    double most = 0;
    for (int k = search.middle_k + step; step * (last - k) > 0; k += step) {
      if (const std::optional<Step> found = step_at(search, p, k, region)) {
        steps.emplace_back(k, *found);
        most = std::max(most, found->change);
      }
    }
    if (most < least) {
      planes.push_back(last + 0.5 * step);
      ++told;
      continue;
    }
    inside = true;
    auto at = std::find_if(steps.begin(), steps.end(), [&](const auto& s) {
      return s.second.change >= kFirstOfChanges * most;
    });
    // A ventricle narrows below its base, too: the plane lies where most changes, as far as it
    // changes ever more.
    while (at + 1 != steps.end() && (at + 1)->second.change > at->second.change) ++at;
    const bool mixed = at->second.unexplained <= kMostUnexplained;
    told += mixed ? 1 : 0;
    if (mixed) fat_mm.push_back(fat_on_wall_mm(search, p, at->first - step, region));
    planes.push_back(mixed ? at->first + step * (at->second.share - 0.5) : std::nan(""));
  }
  if (!inside || told < kLeastPhases * static_cast<double>(planes.size())) return {};
  planes = without_outliers(filled(planes));
  if (under_fat && !fat_mm.empty()) {
    const double mean_mm =
        std::accumulate(fat_mm.begin(), fat_mm.end(), 0.0) / static_cast<double>(fat_mm.size());
    for (double& plane : planes) plane -= step * mean_mm / search.labels.grid.spacing_mm()[2];
  }
  return planes;
}

}  // namespace beatlas::segment
