#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "runtime/atlas/payloads.h"

namespace beatlas::pack {

/// Largest difference of the distance at a leaf's samples and phases [mm], for each leaf. At a
/// sample a spline is 1/6, 4/6, 1/6 of three coefficients along each axis and in time. Samples that
/// are beyond a clamp in both do not count.
/// @pre both have the same blocks, phases and step.
[[nodiscard]] std::vector<double> leaf_errors_mm(const atlas::FieldPayload& given,
                                                 const atlas::FieldPayload& stored);

/// The leaves around each leaf, itself included; negative where there is none. x fastest.
using LeafNeighbours = std::array<std::int32_t, 27>;
[[nodiscard]] std::vector<LeafNeighbours> leaf_neighbours(const atlas::FieldPayload& field);

}  // namespace beatlas::pack
