#include "pipeline/core/distance_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/core/box.h"

namespace beatlas {
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

/// distance_map of a part of the mask, into that part of `out`.
void map_part(const Grid& grid, const std::vector<std::uint8_t>& mask, bool across_slices,
              const Box& part, std::vector<float>& out) {
  const Grid part_grid = grid.part(part.first, part.size);
  const auto columns = static_cast<std::ptrdiff_t>(part.size[0]);
  const auto for_each_row = [&](const auto& visit) {
    for (int k = 0; k < part.size[2]; ++k) {
      for (int j = 0; j < part.size[1]; ++j) {
        visit(static_cast<std::ptrdiff_t>(
                  grid.offset(part.first[0], part.first[1] + j, part.first[2] + k)),
              static_cast<std::ptrdiff_t>(part_grid.offset(0, j, k)));
      }
    }
  };
  std::vector<std::uint8_t> part_mask(part_grid.count());
  for_each_row([&](std::ptrdiff_t whole, std::ptrdiff_t within) {
    std::copy_n(mask.begin() + whole, columns, part_mask.begin() + within);
  });
  const std::vector<float> found = distance_map(part_grid, part_mask, across_slices);
  for_each_row([&](std::ptrdiff_t whole, std::ptrdiff_t within) {
    std::copy_n(found.begin() + within, columns, out.begin() + whole);
  });
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

std::vector<float> distance_near(const Grid& grid, const std::vector<std::uint8_t>& mask,
                                 bool across_slices, double reach_mm) {
  constexpr float kFar = 0.5F * kNoDistance;
  const Box around = box_around(grid, mask);
  if (around.empty()) return std::vector<float>(mask.size(), kNoDistance);
  std::vector<float> out(mask.size(), kFar);
  Index3 room{};
  for (std::size_t a = 0; a < 3; ++a) {
    room[a] = static_cast<int>(std::ceil(reach_mm / grid.spacing_mm()[static_cast<int>(a)]));
  }
  if (!across_slices) {
    room[2] = 0;
    for (int k = 0; k < grid.size[2]; ++k) {
      const auto from = static_cast<std::ptrdiff_t>(grid.offset(0, 0, k));
      const auto to = from + static_cast<std::ptrdiff_t>(grid.slice_count());
      if (std::any_of(mask.begin() + from, mask.begin() + to, is_set)) continue;
      std::fill(out.begin() + from, out.begin() + to, kNoDistance);
    }
  }
  map_part(grid, mask, across_slices, with_room(grid, around, room), out);
  return out;
}

std::vector<float> depth_within(const Grid& grid, const std::vector<std::uint8_t>& mask,
                                bool across_slices) {
  std::vector<float> out(mask.size(), 0);
  const Box around = box_around(grid, mask);
  if (around.empty()) return out;
  std::vector<std::uint8_t> outside(mask.size());
  std::transform(mask.begin(), mask.end(), outside.begin(),
                 [](std::uint8_t value) { return is_set(value) ? 0 : 1; });
  // What lies just beyond the part is outside, and nearer than all that lies farther.
  map_part(grid, outside, across_slices, with_room(grid, around, {1, 1, 1}), out);
  return out;
}

}  // namespace beatlas
