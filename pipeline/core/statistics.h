#pragma once
/// What a set of numbers is like.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>

namespace beatlas {

/// Of an even number the mean of the middle two; 0 of none.
[[nodiscard]] inline double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*std::max_element(values.begin(), middle) + *middle);
}

/// Pearson's, -1 to 1; 0 where one of the two does not vary.
/// @pre as many values each
[[nodiscard]] inline double correlation(const std::vector<double>& a,
                                        const std::vector<double>& b) {
  const auto n = static_cast<double>(a.size());
  const double mean_a = std::accumulate(a.begin(), a.end(), 0.0) / n;
  const double mean_b = std::accumulate(b.begin(), b.end(), 0.0) / n;
  double product = 0;
  double square_a = 0;
  double square_b = 0;
  for (std::size_t v = 0; v < a.size(); ++v) {
    product += (a[v] - mean_a) * (b[v] - mean_b);
    square_a += (a[v] - mean_a) * (a[v] - mean_a);
    square_b += (b[v] - mean_b) * (b[v] - mean_b);
  }
  return square_a > 0 && square_b > 0 ? product / std::sqrt(square_a * square_b) : 0;
}

}  // namespace beatlas
