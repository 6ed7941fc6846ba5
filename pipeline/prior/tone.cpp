#include "pipeline/prior/tone.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "pipeline/prior/stored.h"
#include "runtime/atlas/structures.h"

namespace beatlas::prior {
namespace {

constexpr std::array<std::uint8_t, 3> kJudged{kLabelLvBlood, kLabelLvMyocardium, kLabelRvBlood};

/// Voxels, as they are likely to be of a structure.
struct Likely {
  double all = 0;        ///< that are of it
  double likeliest = 0;  ///< whose likeliest label it is
  double right = 0;      ///< and how many of these are of it
};

Likely likely_of(const PriorCycle& looked, std::size_t output, const Window& window) {
  const std::array<float, 129>& probability = stored_probabilities();
  const std::size_t count = looked.grid.count();
  Likely out;
  for (std::size_t p = 0; p < looked.phases.size(); ++p) {
    if (looked.phases[p].empty()) continue;
    for (int line = 0; line < window.size[1] * window.size[2]; ++line) {
      const std::size_t first =
          looked.grid.offset(window.first[0], window.first[1] + line % window.size[1],
                             window.first[2] + line / window.size[1]);
      for (std::size_t v = first; v < first + static_cast<std::size_t>(window.size[0]); ++v) {
        const auto stored = static_cast<std::size_t>(-looked.phases[p][output * count + v]);
        const auto likely = static_cast<double>(probability[stored]);
        out.all += likely;
        if (looked.likeliest(p, v) != looked.labels[output]) continue;
        out.likeliest += 1;
        out.right += likely;
      }
    }
  }
  return out;
}

}  // namespace

double expected_dice(const PriorCycle& looked, const Window& window) {
  double sum = 0;
  for (std::size_t o = 0; o < looked.labels.size(); ++o) {
    if (std::find(kJudged.begin(), kJudged.end(), looked.labels[o]) == kJudged.end()) continue;
    const Likely likely = likely_of(looked, o, window);
    if (likely.likeliest > 0) sum += 2 * likely.right / (likely.likeliest + likely.all);
  }
  return sum / static_cast<double>(kJudged.size());
}

}  // namespace beatlas::prior
