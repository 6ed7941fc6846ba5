#include "pipeline/prior/stored.h"

#include <algorithm>
#include <cmath>

namespace beatlas::prior {

std::int8_t stored_log(float probability) {
  const float log = std::log(probability);
  const bool likely = log > static_cast<float>(PriorCycle::kLeast);
  const float kept = likely ? std::min(log, 0.0F) : static_cast<float>(PriorCycle::kLeast);
  return static_cast<std::int8_t>(std::lround(kept * PriorCycle::kUnits));
}

const std::array<float, 129>& stored_probabilities() {
  static const std::array<float, 129> table = [] {
    std::array<float, 129> out{};
    for (std::size_t n = 0; n < out.size(); ++n) {
      out[n] = static_cast<float>(std::exp(-static_cast<double>(n) / PriorCycle::kUnits));
    }
    return out;
  }();
  return table;
}

}  // namespace beatlas::prior
