#pragma once
/// Blocks of a field's lattice, as its queries count them. Not an interface.

#include <cstddef>

#include "runtime/atlas/payloads.h"

namespace beatlas::field {

inline constexpr int kEdge = atlas::FieldPayload::kBlockEdge;

/// A count as an index.
inline std::size_t at(int n) noexcept { return static_cast<std::size_t>(n); }

/// Calls visit(first, entry) for every block, in the order in which they are stored.
/// `first` is the index of its first sample in the lattice, `entry` what FieldPayload::blocks says.
template <class Visit>
void for_each_block(const atlas::FieldPayload& field, const Visit& visit) {
  std::size_t block = 0;
  for (int z = 0; z < field.block_count[2]; ++z) {
    for (int y = 0; y < field.block_count[1]; ++y) {
      for (int x = 0; x < field.block_count[0]; ++x, ++block) {
        visit(Index3{kEdge * x, kEdge * y, kEdge * z}, field.blocks[block]);
      }
    }
  }
}

}  // namespace beatlas::field
