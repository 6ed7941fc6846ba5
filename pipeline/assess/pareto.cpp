#include "pipeline/assess/pareto.h"

#include <algorithm>
#include <cmath>

#include "runtime/base/error.h"

namespace beatlas::assess {

std::vector<bool> pareto_front(const std::vector<std::array<double, 2>>& points) {
  const auto usable = [](const std::array<double, 2>& p) {
    return std::isfinite(p[0]) && std::isfinite(p[1]);
  };
  std::vector<bool> front(points.size());
  for (std::size_t n = 0; n < points.size(); ++n) {
    const auto& mine = points[n];
    front[n] = usable(mine) && std::none_of(points.begin(), points.end(), [&](const auto& other) {
                 return usable(other) && other[0] <= mine[0] && other[1] <= mine[1] &&
                        (other[0] < mine[0] || other[1] < mine[1]);
               });
  }
  return front;
}

PowerLaw fit_power_law(const std::vector<double>& x, const std::vector<double>& y) {
  std::vector<std::array<double, 2>> logs;
  for (std::size_t n = 0; n < std::min(x.size(), y.size()); ++n) {
    if (x[n] > 0 && y[n] > 0 && std::isfinite(x[n]) && std::isfinite(y[n])) {
      logs.push_back({std::log(x[n]), std::log(y[n])});
    }
  }
  const auto count = static_cast<double>(logs.size());
  double mean_x = 0;
  double mean_y = 0;
  for (const auto& [a, b] : logs) {
    mean_x += a / count;
    mean_y += b / count;
  }
  double xx = 0;
  double xy = 0;
  for (const auto& [a, b] : logs) {
    xx += (a - mean_x) * (a - mean_x);
    xy += (a - mean_x) * (b - mean_y);
  }
  if (!(xx > 1e-12)) {
    throw_invalid("an exponent needs figures at two different sizes at least");
  }
  PowerLaw out;
  out.points = static_cast<int>(logs.size());
  out.exponent = xy / xx;
  out.factor = std::exp(mean_y - out.exponent * mean_x);
  double squares = 0;
  for (const auto& [a, b] : logs) {
    const double off = b - (mean_y + out.exponent * (a - mean_x));
    squares += off * off;
  }
  out.residual = std::sqrt(squares / count);
  return out;
}

}  // namespace beatlas::assess
