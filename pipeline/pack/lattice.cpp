#include "pipeline/pack/lattice.h"

#include <algorithm>

#include "pipeline/core/parallel.h"

namespace beatlas::pack {
namespace {

/// Along one line, whose samples lie `step` apart: sets those within `radius` of one that is set.
void dilate_line(const std::uint8_t* from, std::uint8_t* to, int length, std::size_t step,
                 int radius) {
  int last = -radius - 1;  // the last sample set at or before the window's end
  for (int n = 0; n < std::min(radius, length); ++n) {
    if (from[static_cast<std::size_t>(n) * step] != 0) last = n;
  }
  for (int n = 0; n < length; ++n) {
    const int end = n + radius;
    if (end < length && from[static_cast<std::size_t>(end) * step] != 0) last = end;
    to[static_cast<std::size_t>(n) * step] = last >= n - radius ? 1 : 0;
  }
}

}  // namespace

SampleMask dilate(const Lattice& lattice, const SampleMask& mask, int radius) {
  SampleMask from = mask;
  SampleMask to(mask.size());
  for (int axis = 0; axis < 3; ++axis) {
    const int length = lattice.size[static_cast<std::size_t>(axis)];
    const std::size_t step = lattice.stride(axis);
    const int u = axis == 0 ? 1 : 0;  // the two other axes
    const int v = axis == 2 ? 1 : 2;
    const int u_size = lattice.size[static_cast<std::size_t>(u)];
    const auto v_size = static_cast<std::size_t>(lattice.size[static_cast<std::size_t>(v)]);
    parallel_for(v_size, [&](std::size_t iv) {
      for (int iu = 0; iu < u_size; ++iu) {
        const std::size_t start =
            static_cast<std::size_t>(iu) * lattice.stride(u) + iv * lattice.stride(v);
        dilate_line(from.data() + start, to.data() + start, length, step, radius);
      }
    });
    std::swap(from, to);
  }
  return from;
}

}  // namespace beatlas::pack
