#include "pipeline/edges/fat_layer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include <opencv2/imgproc.hpp>

#include "pipeline/core/parallel.h"
#include "pipeline/edges/layer_fit.h"
#include "pipeline/edges/outline.h"
#include "pipeline/edges/slice_image.h"
#include "runtime/atlas/structures.h"

namespace beatlas::edges {
namespace {

constexpr int kRoomPx = 8;                ///< around the heart
constexpr float kNearPx = 6;              ///< so far outside fat is looked for
constexpr float kWithinPx = 4;            ///< and so far inside: labels may hold it
constexpr double kBlurPx = 0.7;           ///< Gaussian before fat's level is looked for
constexpr double kOfBlur = 0.4;           ///< of the noise that it leaves: 1 / (2 sqrt(pi) blur)
constexpr double kOverBlood = 3;          ///< standard deviations over blood
constexpr double kLeastShare = 0.005;     ///< of voxels there that are bright, or there is no fat
constexpr double kLeastStep = 0.15;       ///< of the way from muscle to blood, where it is duller
constexpr double kLeastDullShare = 0.03;  ///< of voxels outside that are brighter than that
constexpr double kFatQuantile = 0.9;      ///< of bright ones: most are mixed with something darker
constexpr double kOfNoise = 1.28;         ///< standard deviations that such a quantile lies above
constexpr std::array kAlongInTurnPx{2.0,
                                    5.0};  ///< Gaussian along the outline: fine, then for thin fat
constexpr double kReachSigmas = 2.5;
constexpr int kLeastOutlinePx = 24;
constexpr int kBloodReach = 3;     ///< pixels of the outline: blood so near hides muscle
constexpr double kMixedPx = 0.75;  ///< beside blood
constexpr int kAgree = 3;          ///< places on both sides that have to agree, by half
constexpr float kToldPx = 3;       ///< beside the edge, whose coverage is told

bool is_blood(std::uint8_t label) { return label == kLabelLvBlood || label == kLabelRvBlood; }

/// What the heart's outline and what lies around it look like in one slice of one phase.
struct Slice {
  cv::Rect part;
  cv::Mat pixels;
  cv::Mat labels;
  cv::Mat distance_px;  ///< empty: no heart
};

std::vector<Slice> slices_of(const Grid& grid, const std::vector<float>& image,
                             const std::vector<std::uint8_t>& labels) {
  std::vector<Slice> out(static_cast<std::size_t>(grid.size[2]));
  cv::Rect part;
  for (int k = 0; k < grid.size[2]; ++k) part |= rect_around(slice_of(grid, labels, k), kRoomPx);
  for (int k = 0; k < grid.size[2] && !part.empty(); ++k) {
    Slice& slice = out[static_cast<std::size_t>(k)];
    slice.part = part;
    slice.pixels = slice_of(grid, image, k)(part);
    slice.labels = slice_of(grid, labels, k)(part);
    const cv::Mat heart = slice.labels != 0;
    if (cv::countNonZero(heart) > 0) slice.distance_px = outline_distance_px(heart);
  }
  return out;
}

/// Intensities around the heart, calmed: outside it and a little within, for labels may hold fat.
std::vector<float> calm_around(const ImageCycle<float>& images,
                               const ImageCycle<std::uint8_t>& labels, int phase, float from_px) {
  const auto p = static_cast<std::size_t>(phase);
  std::vector<float> out;
  for (const Slice& slice : slices_of(images.grid, images.phases[p], labels.phases[p])) {
    if (slice.distance_px.empty()) continue;
    cv::Mat calm;
    cv::GaussianBlur(slice.pixels, calm, {0, 0}, kBlurPx);
    for (int j = 0; j < calm.rows; ++j) {
      for (int i = 0; i < calm.cols; ++i) {
        const float d = slice.distance_px.at<float>(j, i);
        if (d < from_px || d > kNearPx) continue;
        if (!is_blood(slice.labels.at<std::uint8_t>(j, i))) out.push_back(calm.at<float>(j, i));
      }
    }
  }
  return out;
}

/// The quantile of what is brighter, if there is enough of it.
std::optional<double> level_above(std::vector<float> values, double bound, double least_share,
                                  double quantile) {
  const auto bright = std::partition(values.begin(), values.end(), [&](float value) {
    return static_cast<double>(value) <= bound;
  });
  const auto count = static_cast<double>(values.end() - bright);
  if (count < 1 || count < least_share * static_cast<double>(values.size())) return {};
  const auto at = bright + static_cast<std::ptrdiff_t>(quantile * (count - 1));
  std::nth_element(bright, at, values.end());
  return static_cast<double>(*at);
}

/// Fat's level, where it lies around the heart at all: brighter than blood or, where contrast is
/// low, between muscle and blood.
std::optional<double> fat_around(const ImageCycle<float>& images, double noise,
                                 const tissue::TissueLevels& levels,
                                 const ImageCycle<std::uint8_t>& labels, int phase) {
  const double left = kOfBlur * noise;
  const auto bright = level_above(calm_around(images, labels, phase, -kWithinPx),
                                  levels.blood + kOverBlood * left, kLeastShare, kFatQuantile);
  if (bright) return *bright - kOfNoise * left;
  return level_above(calm_around(images, labels, phase, 1),
                     levels.muscle + kLeastStep * (levels.blood - levels.muscle), kLeastDullShare,
                     0.5);
}

/// Sums over the pixels beside one outline, by place along it and distance from it.
class Profiles {
 public:
  Profiles(const std::vector<cv::Point>& outline, std::size_t first)
      : first_(first), places_(outline.size()), told_(outline.size()), blood_px_(outline.size()) {
    std::fill(blood_px_.begin(), blood_px_.end(), -std::numeric_limits<double>::infinity());
  }

  void add(std::size_t place, double distance_px, float value, std::uint8_t label) {
    const std::size_t at = place - first_;
    if (is_blood(label)) {
      blood_px_[at] = std::max(blood_px_[at], distance_px);
      return;
    }
    const double bin = (distance_px - AcrossProfile::kFromPx) / AcrossProfile::kBinPx;
    if (!(bin >= 0) || bin >= static_cast<double>(AcrossProfile::kBins)) return;
    const auto n = static_cast<std::size_t>(bin);
    told_[at].mean[n] += static_cast<double>(value);
    told_[at].weight[n] += 1;
  }

  /// The mean along the outline around a place, outside of blood.
  [[nodiscard]] AcrossProfile around(std::size_t at, double along_px) const {
    AcrossProfile out;
    double blood = -std::numeric_limits<double>::infinity();
    const auto reach = static_cast<int>(kReachSigmas * along_px);
    for (int step = -reach; step <= reach; ++step) {
      const std::size_t near = neighbour(at, step);
      const double weight = std::exp(-0.5 * std::pow(step / along_px, 2));
      for (std::size_t n = 0; n < AcrossProfile::kBins; ++n) {
        out.mean[n] += weight * told_[near].mean[n];
        out.weight[n] += weight * told_[near].weight[n];
      }
      if (std::abs(step) <= kBloodReach) blood = std::max(blood, blood_px_[near]);
    }
    for (std::size_t n = 0; n < AcrossProfile::kBins; ++n) {
      if (out.weight[n] > 0) out.mean[n] /= out.weight[n];
      if (AcrossProfile::middle_px(n) < blood + kMixedPx + 0.5) out.weight[n] = 0;
    }
    return out;
  }

  [[nodiscard]] std::size_t neighbour(std::size_t at, int step) const {
    const auto n = static_cast<std::ptrdiff_t>(places_);
    return static_cast<std::size_t>((static_cast<std::ptrdiff_t>(at) + step + n) % n);
  }

 private:
  std::size_t first_;
  std::size_t places_;
  std::vector<AcrossProfile> told_;  ///< mean: sums
  std::vector<double> blood_px_;     ///< outermost blood
};

using Layers = std::vector<std::optional<FatLayer>>;

/// Each place as most of those around it: a layer, the middle of theirs, or none.
Layers agreed(const Profiles& profiles, const Layers& found) {
  Layers out(found.size());
  for (std::size_t at = 0; at < found.size(); ++at) {
    std::vector<FatLayer> near;
    for (int step = -kAgree; step <= kAgree; ++step) {
      const std::optional<FatLayer>& layer = found[profiles.neighbour(at, step)];
      if (layer) near.push_back(*layer);
    }
    if (near.size() <= static_cast<std::size_t>(kAgree)) continue;
    const auto middle = [&](double FatLayer::*of) {
      std::vector<double> values(near.size());
      std::transform(near.begin(), near.end(), values.begin(),
                     [&](const FatLayer& layer) { return layer.*of; });
      std::nth_element(values.begin(),
                       values.begin() + static_cast<std::ptrdiff_t>(near.size() / 2), values.end());
      return values[near.size() / 2];
    };
    out[at] = FatLayer{middle(&FatLayer::edge_px), middle(&FatLayer::thickness_px),
                       middle(&FatLayer::edge_sigma_px)};
  }
  return out;
}

/// Of one slice.
struct Strip {
  cv::Mat labels;
  std::vector<FatEdge> edges;
};

class SliceFat {
 public:
  SliceFat(const Grid& grid, const Slice& slice, std::size_t k, const LayerLevels& levels)
      : grid_(grid), slice_(slice), k_(k), levels_(levels) {}

  /// @return nothing where there is no layer
  [[nodiscard]] std::optional<Strip> strip() const {
    std::vector<std::vector<cv::Point>> outlines;
    cv::findContours(cv::Mat(slice_.labels != 0), outlines, cv::RETR_EXTERNAL,
                     cv::CHAIN_APPROX_NONE);
    std::erase_if(outlines, [](const auto& outline) {
      return outline.size() < static_cast<std::size_t>(kLeastOutlinePx);
    });
    if (outlines.empty()) return {};
    const cv::Mat place = nearest_places(outlines);
    std::vector<Profiles> profiles;
    std::vector<std::size_t> first;
    std::size_t count = 0;
    for (const auto& outline : outlines) {
      profiles.emplace_back(outline, count);
      first.push_back(count);
      count += outline.size();
    }
    gather(place, first, profiles);
    Layers layers;
    for (std::size_t o = 0; o < outlines.size(); ++o) {
      Layers found(outlines[o].size());
      for (std::size_t at = 0; at < found.size(); ++at) {
        for (const double along_px : kAlongInTurnPx) {
          if (found[at]) break;
          found[at] = fit_fat_layer(profiles[o].around(at, along_px), levels_);
        }
      }
      const Layers smooth = agreed(profiles[o], found);
      layers.insert(layers.end(), smooth.begin(), smooth.end());
    }
    if (std::none_of(layers.begin(), layers.end(), [](const auto& layer) { return layer; })) {
      return {};
    }
    return without(place, layers);
  }

 private:
  /// Index of the outlines' pixel nearest to each pixel.
  [[nodiscard]] cv::Mat nearest_places(const std::vector<std::vector<cv::Point>>& outlines) const {
    cv::Mat off(slice_.labels.size(), CV_8U, cv::Scalar(255));
    for (const auto& outline : outlines) {
      for (const cv::Point& at : outline) off.at<std::uint8_t>(at) = 0;
    }
    cv::Mat distance;
    cv::Mat zone;
    cv::distanceTransform(off, distance, zone, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
    // Zones are numbered by rows; places follow the outlines. A pixel passed twice keeps its first.
    std::vector<std::int32_t> place_of(
        static_cast<std::size_t>(off.rows) * static_cast<std::size_t>(off.cols) + 1, -1);
    std::int32_t count = 0;
    for (const auto& outline : outlines) {
      for (const cv::Point& at : outline) {
        std::int32_t& place = place_of[static_cast<std::size_t>(zone.at<std::int32_t>(at))];
        if (place < 0) place = count;
        ++count;
      }
    }
    cv::Mat out(off.size(), CV_32S);
    for (int j = 0; j < out.rows; ++j) {
      for (int i = 0; i < out.cols; ++i) {
        out.at<std::int32_t>(j, i) =
            place_of[static_cast<std::size_t>(zone.at<std::int32_t>(j, i))];
      }
    }
    return out;
  }

  void gather(const cv::Mat& place, const std::vector<std::size_t>& first,
              std::vector<Profiles>& profiles) const {
    for (int j = 0; j < place.rows; ++j) {
      for (int i = 0; i < place.cols; ++i) {
        const float d = slice_.distance_px.at<float>(j, i);
        const auto at = static_cast<std::size_t>(place.at<std::int32_t>(j, i));
        const auto after = std::upper_bound(first.begin(), first.end(), at);
        profiles[static_cast<std::size_t>(after - first.begin()) - 1].add(
            at, static_cast<double>(d), slice_.pixels.at<float>(j, i),
            slice_.labels.at<std::uint8_t>(j, i));
      }
    }
  }

  [[nodiscard]] Strip without(const cv::Mat& place, const Layers& layers) const {
    Strip out{slice_.labels.clone(), {}};
    const Vec3 spacing = grid_.spacing_mm();
    const auto pixel_mm = static_cast<float>(std::sqrt(spacing[0] * spacing[1]));
    for (int j = 0; j < place.rows; ++j) {
      for (int i = 0; i < place.cols; ++i) {
        const auto at = static_cast<std::size_t>(place.at<std::int32_t>(j, i));
        const std::optional<FatLayer>& layer = layers[at];
        std::uint8_t& label = out.labels.at<std::uint8_t>(j, i);
        if (!layer || is_blood(label)) continue;
        const float d = slice_.distance_px.at<float>(j, i) - static_cast<float>(layer->edge_px);
        if (d > 0) label = kLabelBackground;
        if (std::abs(d) > kToldPx) continue;
        out.edges.push_back({static_cast<std::uint32_t>(grid_.offset(
                                 slice_.part.x + i, slice_.part.y + j, static_cast<int>(k_))),
                             FatEdge::kNowhere, ramp(d, 0).coverage,
                             pixel_mm * static_cast<float>(layer->edge_sigma_px)});
      }
    }
    return out;
  }

  const Grid& grid_;
  const Slice& slice_;
  std::size_t k_;
  const LayerLevels& levels_;
};

}  // namespace

std::optional<LayerLevels> levels_with_fat(const ImageCycle<float>& images, double noise,
                                           const tissue::TissueLevels& levels,
                                           const ImageCycle<std::uint8_t>& labels) {
  if (!(levels.blood > levels.muscle) || !(levels.muscle > 0)) return {};
  std::vector<double> fats;
  for (const int phase : {0, images.phase_count() / 2}) {
    if (const auto fat = fat_around(images, noise, levels, labels, phase)) fats.push_back(*fat);
  }
  if (fats.empty()) return {};
  const LayerLevels known{.muscle = levels.muscle,
                          .blood = levels.blood,
                          .fat = *std::max_element(fats.begin(), fats.end()),
                          .noise = std::max(noise, 0.01 * (levels.blood - levels.muscle))};
  return known;
}

std::vector<std::vector<FatEdge>> strip_fat_layer(const ImageCycle<float>& images,
                                                  const LayerLevels& levels,
                                                  const std::vector<std::uint8_t>& stay,
                                                  ImageCycle<std::uint8_t>& labels) {
  std::vector<std::vector<FatEdge>> edges(images.phases.size());
  parallel_for(images.phases.size(), [&](std::size_t p) {
    if (stay[p] != 0) return;
    const std::vector<Slice> slices = slices_of(images.grid, images.phases[p], labels.phases[p]);
    std::vector<std::optional<Strip>> strips(slices.size());
    for (std::size_t k = 0; k < slices.size(); ++k) {
      if (slices[k].distance_px.empty()) continue;
      strips[k] = SliceFat(images.grid, slices[k], k, levels).strip();
    }
    for (std::size_t k = 0; k < slices.size(); ++k) {
      if (!strips[k]) continue;
      cv::Mat slice = slice_of(images.grid, labels.phases[p], static_cast<int>(k));
      strips[k]->labels.copyTo(slice(slices[k].part));
      edges[p].insert(edges[p].end(), strips[k]->edges.begin(), strips[k]->edges.end());
    }
  });
  return edges;
}

}  // namespace beatlas::edges
