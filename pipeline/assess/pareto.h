#pragma once
#include <array>
#include <vector>

namespace beatlas::assess {

/// Which of the points no other beats: none is at most as large in both and smaller in one. Points
/// that hold what is no number are never on the front; equal points are on it together.
[[nodiscard]] std::vector<bool> pareto_front(const std::vector<std::array<double, 2>>& points);

/// y = factor x^exponent.
struct PowerLaw {
  double exponent = 0;
  double factor = 0;
  /// Root mean square of ln(y / fitted y): 0.1 is about 10 %.
  double residual = 0;
  int points = 0;
};

/// Least squares in logarithms. Pairs that are not positive and finite are left out.
/// @throws Error{InvalidInput} if fewer than two different x are left.
[[nodiscard]] PowerLaw fit_power_law(const std::vector<double>& x, const std::vector<double>& y);

}  // namespace beatlas::assess
