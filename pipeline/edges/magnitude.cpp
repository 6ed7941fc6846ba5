#include "pipeline/edges/magnitude.h"

#include <algorithm>
#include <cmath>

namespace beatlas::edges {
namespace {

constexpr int kSquareRounds = 4;

/// Mean square of the magnitude is signal^2 + 2 noise^2; its variance grows from 0.43 noise^2
/// without a signal to noise^2. This is the one less the other, of squares over noise^2.
float square_added(float square) { return 1 + 0.571F / (1 + 0.5F * square); }

}  // namespace

float mean_magnitude(float signal, float noise) {
  if (!(noise > 0)) return signal;
  const float square = signal * signal / (noise * noise);
  return noise * std::sqrt(square + square_added(square));
}

float signal_of(float magnitude, float noise) {
  if (!(noise > 0)) return magnitude;
  const float mean = magnitude * magnitude / (noise * noise);
  float square = std::max(0.0F, mean - 1);
  for (int n = 0; n < kSquareRounds; ++n) square = std::max(0.0F, mean - square_added(square));
  return noise * std::sqrt(square);
}

Mixture::Mixture(float inner, float outer, float noise)
    : inner_(inner),
      outer_(outer),
      noise_(noise),
      inner_signal_(signal_of(inner, noise)),
      outer_signal_(signal_of(outer, noise)) {}

float Mixture::magnitude(float share) const {
  // What either end lacks of its own magnitude, noise alone being more, is added.
  return mean_magnitude(share * inner_signal_ + (1 - share) * outer_signal_, noise_);
}

}  // namespace beatlas::edges
