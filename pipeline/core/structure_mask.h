#pragma once
/// A structure's voxels as a mask.

#include <cstdint>
#include <vector>

#include "runtime/atlas/structures.h"

namespace beatlas {

/// 1 where a label belongs to the structure.
[[nodiscard]] std::vector<std::uint8_t> where(const std::vector<std::uint8_t>& labels,
                                              Structure structure);

}  // namespace beatlas
