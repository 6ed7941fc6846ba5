#pragma once
/// Small helpers for encode_field: a box of samples and masks on it.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "runtime/base/geometry.h"

namespace beatlas::pack {

/// A box of samples, x fastest.
struct Lattice {
  Index3 size{0, 0, 0};

  [[nodiscard]] std::size_t row() const { return static_cast<std::size_t>(size[0]); }
  [[nodiscard]] std::size_t slice() const { return row() * static_cast<std::size_t>(size[1]); }
  [[nodiscard]] std::size_t count() const { return slice() * static_cast<std::size_t>(size[2]); }
  /// Steps in memory along x, y, z.
  [[nodiscard]] std::size_t stride(int axis) const {
    return axis == 0 ? 1 : axis == 1 ? row() : slice();
  }
  [[nodiscard]] std::size_t offset(int i, int j, int k) const {
    return static_cast<std::size_t>(i) + row() * static_cast<std::size_t>(j) +
           slice() * static_cast<std::size_t>(k);
  }
};

/// One byte a sample, 0 or 1.
using SampleMask = std::vector<std::uint8_t>;

/// The samples within `radius` (in the maximum norm) of a sample of `mask`.
[[nodiscard]] SampleMask dilate(const Lattice& lattice, const SampleMask& mask, int radius);

}  // namespace beatlas::pack
