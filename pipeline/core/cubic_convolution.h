#pragma once
/// Cubic convolution of samples one apart: Keys, IEEE Trans Acoust Speech Signal Process
/// 1981;29:1153-1160, doi:10.1109/TASSP.1981.1163711, with a = -1/2 (Catmull-Rom). C1, exact for
/// quadratics.

#include <array>

namespace beatlas {

/// Weights of the four samples about a place: of the one before the last that is not beyond it, of
/// that, and of the two after it. They sum to 1.
/// @param t how far the place lies beyond the second, 0 to 1
[[nodiscard]] inline std::array<double, 4> cubic_weights(double t) {
  return {((2.0 - t) * t - 1.0) * t * 0.5, ((3.0 * t - 5.0) * t * t + 2.0) * 0.5,
          ((4.0 - 3.0 * t) * t + 1.0) * t * 0.5, (t - 1.0) * t * t * 0.5};
}

/// What the weights change by with the place. They sum to 0.
[[nodiscard]] inline std::array<double, 4> cubic_slopes(double t) {
  return {((4.0 - 3.0 * t) * t - 1.0) * 0.5, (9.0 * t - 10.0) * t * 0.5,
          ((8.0 - 9.0 * t) * t + 1.0) * 0.5, (3.0 * t - 2.0) * t * 0.5};
}

}  // namespace beatlas
