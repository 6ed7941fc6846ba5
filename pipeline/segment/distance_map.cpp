#include "pipeline/segment/distance_map.h"

#include <cmath>
#include <limits>

namespace beatlas::segment {
namespace {

constexpr float kInfinite = kNoDistance * kNoDistance;

/// Squared distances along one line of `n` samples `step_mm` apart; `stride` between samples.
void transform_line(float* line, std::size_t stride, int n, double step_mm, std::vector<int>& apex,
                    std::vector<double>& border, std::vector<float>& copy) {
  int last = -1;
  for (int q = 0; q < n; ++q) {
    const double f = line[static_cast<std::size_t>(q) * stride];
    copy[static_cast<std::size_t>(q)] = static_cast<float>(f);
    if (f >= kInfinite) continue;
    const double x = q * step_mm;
    double cross = -std::numeric_limits<double>::infinity();
    while (last >= 0) {
      const int a = apex[static_cast<std::size_t>(last)];
      const double xa = a * step_mm;
      cross = ((f + x * x) - (copy[static_cast<std::size_t>(a)] + xa * xa)) / (2 * (x - xa));
      if (cross > border[static_cast<std::size_t>(last)]) break;
      --last;
      cross = -std::numeric_limits<double>::infinity();
    }
    ++last;
    apex[static_cast<std::size_t>(last)] = q;
    border[static_cast<std::size_t>(last)] = cross;
  }
  if (last < 0) return;
  int here = 0;
  for (int q = 0; q < n; ++q) {
    const double x = q * step_mm;
    while (here < last && border[static_cast<std::size_t>(here) + 1] < x) ++here;
    const int a = apex[static_cast<std::size_t>(here)];
    const double d = x - a * step_mm;
    line[static_cast<std::size_t>(q) * stride] =
        static_cast<float>(d * d + copy[static_cast<std::size_t>(a)]);
  }
}

}  // namespace

std::vector<float> distance_map(const Grid& grid, const std::vector<std::uint8_t>& mask,
                                bool across_slices) {
  std::vector<float> squared(mask.size());
  for (std::size_t v = 0; v < mask.size(); ++v) squared[v] = mask[v] != 0 ? 0 : kInfinite;
  const auto longest =
      static_cast<std::size_t>(std::max(grid.size[0], std::max(grid.size[1], grid.size[2])));
  std::vector<int> apex(longest);
  std::vector<double> border(longest);
  std::vector<float> copy(longest);
  const Vec3 spacing = grid.spacing_mm();
  const auto nx = static_cast<std::size_t>(grid.size[0]);
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      transform_line(&squared[grid.offset(0, j, k)], 1, grid.size[0], spacing[0], apex, border,
                     copy);
    }
    for (int i = 0; i < grid.size[0]; ++i) {
      transform_line(&squared[grid.offset(i, 0, k)], nx, grid.size[1], spacing[1], apex, border,
                     copy);
    }
  }
  if (across_slices) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        transform_line(&squared[grid.offset(i, j, 0)], grid.slice_count(), grid.size[2], spacing[2],
                       apex, border, copy);
      }
    }
  }
  for (float& value : squared) value = std::min(std::sqrt(value), kNoDistance);
  return squared;
}

}  // namespace beatlas::segment
