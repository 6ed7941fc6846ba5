#pragma once
/// Probabilities as PriorCycle stores them.

#include <array>
#include <cstdint>

#include "pipeline/prior/prior.h"

namespace beatlas::prior {

/// A probability's logarithm; of what is no number that of what is as unlikely as can be.
[[nodiscard]] std::int8_t stored_log(float probability);

/// Probability of a stored logarithm, 0..-128, at its negative.
[[nodiscard]] const std::array<float, 129>& stored_probabilities();

}  // namespace beatlas::prior
