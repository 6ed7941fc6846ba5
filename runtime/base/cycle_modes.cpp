#include "runtime/base/cycle_modes.h"

#include <cmath>

namespace beatlas {

double cosine_of_turn(std::int64_t turns, std::int64_t of) noexcept {
  turns %= of;
  if (turns < 0) turns += of;
  if (2 * turns > of) turns = of - turns;
  const bool beyond = 4 * turns > of;  // past the quarter: minus that of the rest to the half
  const double share = beyond ? static_cast<double>(of - 2 * turns) / (2 * static_cast<double>(of))
                              : static_cast<double>(turns) / static_cast<double>(of);
  constexpr double kTwoPi = 6.283185307179586476925;
  const double square = kTwoPi * share * (kTwoPi * share);
  double sum = 1;  // Taylor, up to (pi / 2)^26 / 26!
  for (int n = 26; n > 0; n -= 2) sum = 1 - sum * square / (n * (n - 1));
  return beyond ? -sum : sum;
}

std::vector<double> cycle_modes(int phases) {
  const auto count = static_cast<std::size_t>(phases);
  std::vector<double> weights(count * count);
  auto weight = weights.begin();
  for (int m = 0; m < phases; ++m) {
    const int k = mode_frequency(m);
    const bool alone = m == 0 || 2 * k == phases;
    for (int p = 0; p < phases; ++p) {
      const auto turns = std::int64_t{k} * p;
      const double wave = m == 0 || m % 2 == 1 ? cosine_of_turn(turns, phases)
                                               : cosine_of_turn(4 * turns - phases, 4 * phases);
      *weight++ = std::sqrt((alone ? 1 : 2) / static_cast<double>(phases)) * wave;
    }
  }
  return weights;
}

}  // namespace beatlas
