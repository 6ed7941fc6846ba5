#include "pipeline/prior/courses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "pipeline/core/parallel.h"
#include "pipeline/prior/hearts.h"
#include "pipeline/prior/stored.h"
#include "runtime/atlas/structures.h"

namespace beatlas::prior {
namespace {

constexpr float kNothing = 0.01F;  ///< a side that is no likelier in any phase changes nothing

/// Outputs of two sides that exclude each other.
struct Sides {
  std::vector<std::size_t> one;
  std::vector<std::size_t> other;
  std::vector<std::size_t> neither;

  [[nodiscard]] bool known() const { return !one.empty() && !other.empty(); }
};

template <class One, class Other>
Sides sides_of(const std::vector<std::uint8_t>& labels, const One& one, const Other& other) {
  Sides out;
  for (std::size_t o = 0; o < labels.size(); ++o) {
    const bool either = is_among(one, labels[o]);
    (either ? out.one : is_among(other, labels[o]) ? out.other : out.neither).push_back(o);
  }
  return out;
}

/// One place in all phases.
class Place {
 public:
  Place(PriorCycle& prior, std::size_t voxel)
      : prior_(prior), count_(prior.grid.count()), voxel_(voxel) {}

  /// What the sides weigh in each phase. @return whether there is something to tell apart
  bool weigh(const Sides& sides) {
    const std::size_t phases = prior_.phases.size();
    one_.resize(phases);
    other_.resize(phases);
    float most_one = 0;
    float most_other = 0;
    for (std::size_t p = 0; p < phases; ++p) {
      one_[p] = sum(sides.one, p);
      other_[p] = sum(sides.other, p);
      most_one = std::max(most_one, one_[p]);
      most_other = std::max(most_other, other_[p]);
    }
    return std::min(most_one, most_other) >= kNothing;
  }

  /// Logarithm of how likely what the network says of a phase is on the other side, over the one.
  [[nodiscard]] double odds(std::size_t phase) const {
    return std::log(without_one(phase) / without_other(phase));
  }

  /// What is likely in a phase, where the other side has a share and the one has the rest.
  void part(const Sides& sides, std::size_t phase, double other) {
    const double one = (1 - other) / without_other(phase);
    const double those = other / without_one(phase);
    scale(sides.one, phase, one);
    scale(sides.other, phase, those);
    scale(sides.neither, phase, one + those);
  }

 private:
  [[nodiscard]] double without_one(std::size_t phase) const {
    return std::max(static_cast<double>(1 - one_[phase]), static_cast<double>(other_[phase]));
  }

  [[nodiscard]] double without_other(std::size_t phase) const {
    return std::max(static_cast<double>(1 - other_[phase]), static_cast<double>(one_[phase]));
  }

  [[nodiscard]] float probability(std::size_t output, std::size_t phase) const {
    const std::int8_t log = prior_.phases[phase][output * count_ + voxel_];
    return stored_probabilities()[static_cast<std::size_t>(-log)];
  }

  [[nodiscard]] float sum(const std::vector<std::size_t>& outputs, std::size_t phase) const {
    float all = 0;
    for (const std::size_t o : outputs) all += probability(o, phase);
    return all;
  }

  void scale(const std::vector<std::size_t>& outputs, std::size_t phase, double factor) {
    for (const std::size_t o : outputs) {
      prior_.phases[phase][o * count_ + voxel_] =
          stored_log(probability(o, phase) * static_cast<float>(factor));
    }
  }

  PriorCycle& prior_;
  std::size_t count_;
  std::size_t voxel_;
  std::vector<float> one_;
  std::vector<float> other_;
};

/// Share of the courses that are on the other side in each phase, of those that change to it once,
/// before some phase, and stay.
/// @param odds [phase] of the other side over the one, logarithm
std::vector<double> shares_of_changes(const std::vector<double>& odds) {
  const std::size_t n = odds.size();
  // A change before a phase weighs what all that follows says for the other side; logarithms.
  std::vector<double> weight(n + 1, 0);
  for (std::size_t p = n; p-- > 0;) weight[p] = weight[p + 1] + odds[p];
  for (std::size_t p = 1; p < n; ++p) weight[p] -= std::log(static_cast<double>(n - 1));
  const double most = *std::max_element(weight.begin(), weight.end());
  for (double& w : weight) w = std::exp(w - most);
  const double all = std::accumulate(weight.begin(), weight.end(), 0.0);
  double changed = 0;
  std::vector<double> out(n);
  for (std::size_t p = 0; p < n; ++p) out[p] = std::min(1.0, (changed += weight[p]) / all);
  return out;
}

/// The phases from that in which the LV's blood has most volume to that in which it has least.
std::vector<std::size_t> by_volume(const PriorCycle& prior) {
  const std::size_t count = prior.grid.count();
  const auto lv = std::find(prior.labels.begin(), prior.labels.end(), kLabelLvBlood);
  std::vector<double> volumes(prior.phases.size(), 0);
  if (lv != prior.labels.end()) {
    const auto first = static_cast<std::size_t>(lv - prior.labels.begin()) * count;
    parallel_for(volumes.size(), [&](std::size_t p) {
      for (std::size_t v = first; v < first + count; ++v) {
        volumes[p] += static_cast<double>(
            stored_probabilities()[static_cast<std::size_t>(-prior.phases[p][v])]);
      }
    });
  }
  std::vector<std::size_t> out(volumes.size());
  std::iota(out.begin(), out.end(), std::size_t{0});
  std::stable_sort(out.begin(), out.end(),
                   [&](std::size_t a, std::size_t b) { return volumes[a] > volumes[b]; });
  return out;
}

}  // namespace

void hold_courses(PriorCycle& prior) {
  const std::size_t phases = prior.phases.size();
  if (phases < 2) return;
  const Sides hearts = sides_of(prior.labels, kLeftBloodLabels, kRightBloodLabels);
  const Sides ends =
      sides_of(prior.labels, std::array{kLabelRvBlood, kLabelLvMyocardium, kLabelLvBlood},
               std::array{kLabelRestOfHeart, kLabelLaBlood, kLabelRaBlood, kLabelAorta});
  const std::vector<std::size_t> order = by_volume(prior);
  const auto row = static_cast<std::size_t>(prior.grid.size[0]);
  parallel_for(prior.grid.count() / row, [&](std::size_t r) {
    for (std::size_t v = r * row; v < (r + 1) * row; ++v) {
      Place place(prior, v);
      if (hearts.known() && place.weigh(hearts)) {
        double odds = 0;
        for (std::size_t p = 0; p < phases; ++p) odds += place.odds(p);
        for (std::size_t p = 0; p < phases; ++p) {
          place.part(hearts, p, 1 / (1 + std::exp(-odds)));
        }
      }
      if (!ends.known() || !place.weigh(ends)) continue;
      std::vector<double> odds(phases);
      for (std::size_t p = 0; p < phases; ++p) odds[p] = place.odds(order[p]);
      const std::vector<double> beyond = shares_of_changes(odds);
      for (std::size_t p = 0; p < phases; ++p) place.part(ends, order[p], beyond[p]);
    }
  });
}

}  // namespace beatlas::prior
