#include "pipeline/ingest/slice_axis.h"

#include <algorithm>
#include <array>
#include <utility>

#include "pipeline/core/parallel.h"

namespace beatlas::ingest {
namespace {

/// Of the largest spacing over the next; below, axes count as alike.
constexpr double kApart = 1.2;

}  // namespace

int slice_axis(const Grid& grid) {
  const Vec3 spacing = grid.spacing_mm();
  std::array<int, 3> order{0, 1, 2};
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return spacing[a] < spacing[b]; });
  const auto [least, middle, most] = order;
  const double apart = spacing[most] / spacing[middle];
  const auto count = [&](int axis) { return grid.size[static_cast<std::size_t>(axis)]; };
  const bool few = count(most) < count(middle) && count(most) < count(least);
  return few && apart >= kApart && apart > spacing[middle] / spacing[least] ? most : 2;
}

void put_axis_last(ImageCycle<float>& images, int axis) {
  if (axis == 2) return;
  const Grid from = images.grid;
  const std::array<int, 3> order{(axis + 1) % 3, (axis + 2) % 3, axis};
  const std::array<std::size_t, 3> strides{1, from.offset(0, 1, 0), from.offset(0, 0, 1)};
  std::array<std::size_t, 3> step{};
  Grid& to = images.grid;
  for (std::size_t n = 0; n < 3; ++n) {
    to.size[n] = from.size[static_cast<std::size_t>(order[n])];
    step[n] = strides[static_cast<std::size_t>(order[n])];
    to.mm_from_index.linear().col(static_cast<Eigen::Index>(n)) =
        from.mm_from_index.linear().col(order[n]);
  }
  parallel_for(images.phases.size(), [&](std::size_t p) {
    std::vector<float> turned(to.count());
    std::size_t v = 0;
    for (int k = 0; k < to.size[2]; ++k) {
      for (int j = 0; j < to.size[1]; ++j) {
        std::size_t at =
            static_cast<std::size_t>(k) * step[2] + static_cast<std::size_t>(j) * step[1];
        for (int i = 0; i < to.size[0]; ++i, at += step[0]) turned[v++] = images.phases[p][at];
      }
    }
    images.phases[p] = std::move(turned);
  });
}

}  // namespace beatlas::ingest
