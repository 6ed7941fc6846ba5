#include "pipeline/segment/known_seeds.h"

#include <algorithm>
#include <array>

#include "pipeline/core/parallel.h"
#include "pipeline/segment/distance_map.h"

namespace beatlas::segment {
namespace {

constexpr std::size_t kLabels = TravelCost::kLabels;
constexpr double kEdgeMm = 4;         ///< left to the image, which then tells how it errs
constexpr double kSteadyMm = 3;       ///< in from the edges of what all known phases share
constexpr double kFarSteadyMm = 8;    ///< the same where they leave most of the cycle untold
constexpr double kMostUntold = 0.75;  ///< of the cycle, between two known phases: ED to ES and back
constexpr double kReachMm = 10;       ///< walls move no farther between known phases and others
constexpr double kNearRestMm = 5;     ///< atria fill and empty less than that beyond known outlines

using Mask = std::vector<std::uint8_t>;

bool is_known(const KnownLabels& known, std::size_t phase) {
  return std::binary_search(known.phases.begin(), known.phases.end(), static_cast<int>(phase));
}

/// The longest run of the cycle without a known phase, as a share of it.
double longest_gap(const std::vector<int>& phases, int count) {
  int longest = phases.front() + count - phases.back();
  for (std::size_t at = 1; at < phases.size(); ++at) {
    longest = std::max(longest, phases[at] - phases[at - 1]);
  }
  return static_cast<double>(longest) / count;
}

/// Distance [mm] to the nearest voxel in `mask`, within slices where those are thick.
std::vector<float> away_from(const Grid& grid, const Mask& mask) {
  return distance_map(grid, mask, grid.spacing_mm()[2] < kThickSlicesMm);
}

/// Whether an intensity may be that of a label.
bool may_be(std::uint8_t label, float intensity, const TissueLevels& levels) {
  if (!(levels.threshold > 0)) return true;
  if (label == kLabelLvMyocardium) return intensity < levels.threshold;
  if (label == kLabelLvBlood || label == kLabelRvBlood) return intensity > levels.threshold;
  return true;
}

bool is_pool(std::uint8_t label) {
  return label == kLabelRvBlood || label == kLabelLvBlood || label == kLabelRestOfHeart;
}

/// Whether a known phase has another pool at a voxel than a seed says: between two pools there is
/// valve plane and no edge, and of its way the known phases tell more than the images.
bool is_disputed(const KnownLabels& known, std::size_t v, std::uint8_t seed) {
  return is_pool(seed) &&
         std::any_of(known.labels.phases.begin(), known.labels.phases.end(),
                     [&](const Mask& phase) { return is_pool(phase[v]) && phase[v] != seed; });
}

std::array<bool, kLabels> labels_of(const KnownLabels& known) {
  std::array<bool, kLabels> there{};
  there[kLabelBackground] = true;
  for (const Mask& phase : known.labels.phases) {
    for (const std::uint8_t label : phase) there[label] = true;
  }
  return there;
}

}  // namespace

Box box_with_labels(const Grid& grid, const Box& box, const KnownLabels& known) {
  return widened(grid, box, box_around(grid, known.labels.phases));
}

KnownLabels crop(const KnownLabels& known, const Box& box) {
  if (known.phases.empty()) return {};
  return {crop(known.labels, box), known.phases};
}

void seed_known(const ImageCycle<float>& images, const KnownLabels& known, bool automatic_lv,
                const TissueLevels& levels, LabelImages& seeds) {
  if (known.phases.empty()) return;
  const Grid& grid = images.grid;
  const std::size_t count = grid.count();
  const bool far = longest_gap(known.phases, images.phase_count()) > kMostUntold;
  const double steady_mm = far ? kFarSteadyMm : kSteadyMm;

  // By label: where it is in every known phase and how deep, where in none and how far off.
  std::array<std::vector<float>, kLabels> depth;
  std::array<std::vector<float>, kLabels> off;
  parallel_for(kLabels, [&](std::size_t label) {
    Mask not_in_all(count, 0);
    Mask in_some(count, 0);
    for (const Mask& phase : known.labels.phases) {
      for (std::size_t v = 0; v < count; ++v) {
        (phase[v] == label ? in_some : not_in_all)[v] = 1;
      }
    }
    depth[label] = away_from(grid, not_in_all);
    off[label] = label == kLabelBackground ? std::vector<float>() : away_from(grid, in_some);
    if (label == kLabelBackground) {
      off[label].resize(count);
      for (std::size_t v = 0; v < count; ++v) off[label][v] = in_some[v] != 0 ? 0 : kNoDistance;
    }
  });
  parallel_for(seeds.size(), [&](std::size_t p) {
    if (is_known(known, p) || (known.phases.size() == 1 && automatic_lv)) return;
    for (std::size_t v = 0; v < count; ++v) {
      std::uint8_t& seed = seeds[p][v];
      if (seed != kUnlabelled && (off[seed][v] > kReachMm || is_disputed(known, v, seed))) {
        seed = kUnlabelled;
      }
      for (std::uint8_t label = 0; label < kLabels; ++label) {
        // What lies outside may come nearer with each beat; a heart's own parts stay side by side.
        const double least_mm = label == kLabelBackground ? 2 * steady_mm : steady_mm;
        if (depth[label][v] >= least_mm && may_be(label, images.phases[p][v], levels)) {
          seed = label;
        }
      }
    }
  });
  for (std::size_t at = 0; at < known.phases.size(); ++at) {
    Mask& phase = seeds[static_cast<std::size_t>(known.phases[at])];
    const Mask& labels = known.labels.phases[at];
    std::fill(phase.begin(), phase.end(), kUnlabelled);
    for (std::uint8_t label = 0; label < kLabels; ++label) {
      Mask others(count);
      std::transform(labels.begin(), labels.end(), others.begin(),
                     [&](std::uint8_t here) { return static_cast<std::uint8_t>(here != label); });
      const std::vector<float> inside = away_from(grid, others);
      for (std::size_t v = 0; v < count; ++v) {
        if (inside[v] >= kEdgeMm) phase[v] = label;
      }
    }
  }
}

std::vector<std::uint8_t> near_known_rest(const KnownLabels& known) {
  Mask rest;
  for (const Mask& phase : known.labels.phases) {
    rest.resize(phase.size(), 0);
    for (std::size_t v = 0; v < phase.size(); ++v) rest[v] |= phase[v] == kLabelRestOfHeart;
  }
  if (std::find(rest.begin(), rest.end(), 1) == rest.end()) return {};
  const std::vector<float> away = away_from(known.labels.grid, rest);
  std::transform(away.begin(), away.end(), rest.begin(),
                 [](float mm) { return static_cast<std::uint8_t>(mm <= kNearRestMm); });
  return rest;
}

void keep_known_rest(const std::vector<std::uint8_t>& near_known_rest,
                     const std::vector<std::uint8_t>& grown, std::vector<std::uint8_t>& labels) {
  for (std::size_t v = 0; v < near_known_rest.size(); ++v) {
    if (near_known_rest[v] != 0 && grown[v] == kLabelRestOfHeart && labels[v] == kLabelBackground) {
      labels[v] = kLabelRestOfHeart;
    }
  }
}

void drop_unknown_labels(const KnownLabels& known, ImageCycle<std::uint8_t>& labels) {
  if (known.phases.empty()) return;
  const std::array<bool, kLabels> there = labels_of(known);
  for (Mask& phase : labels.phases) {
    for (std::uint8_t& label : phase) {
      if (!there[label]) label = kLabelBackground;
    }
  }
}

}  // namespace beatlas::segment
