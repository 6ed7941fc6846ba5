#pragma once
/// Blocks of a field's lattice, as its queries count them. Not an interface.

#include <cstddef>

#include "runtime/atlas/payloads.h"

namespace beatlas::field {

inline constexpr int kEdge = atlas::FieldPayload::kBlockEdge;

/// A count as an index.
inline std::size_t at(int n) noexcept { return static_cast<std::size_t>(n); }

}  // namespace beatlas::field
