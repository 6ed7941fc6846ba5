#pragma once
/// What must hold of a closed triangle surface that moves, whatever it shows.

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "runtime/base/geometry.h"

namespace beatlas::assess {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

/// Enclosed volume of a closed surface [ml] by the divergence theorem; > 0 if its triangles are
/// counter-clockwise seen from outside.
[[nodiscard]] double enclosed_volume_ml(const Triangles& triangles,
                                        const std::vector<Vec3f>& positions);

/// Directed edges that do not meet exactly one opposite; 0 for a closed, oriented surface.
[[nodiscard]] std::size_t open_edges(const Triangles& triangles);

/// Vertices whose triangles are not one fan around them (two cones that touch); 0 for a 2-manifold.
/// @pre no open edge
[[nodiscard]] std::size_t pinched_vertices(const Triangles& triangles);

/// Pairs of triangles without a common vertex that cut each other.
[[nodiscard]] std::size_t crossing_triangles(const Triangles& triangles,
                                             const std::vector<Vec3f>& positions);
/// Pairs of triangles, one of either surface, that cut each other.
[[nodiscard]] std::size_t crossing_triangles(const Triangles& triangles,
                                             const std::vector<Vec3f>& positions,
                                             const Triangles& other_triangles,
                                             const std::vector<Vec3f>& other_positions);

/// RMS step of the vertices from the last phase to the first, over the largest such step between
/// neighbours elsewhere in the cycle; 0 if nothing moves or there are less than 3 phases. A cycle
/// that closes smoothly is at most about 1.
[[nodiscard]] double wrap_step_ratio(const std::vector<std::vector<Vec3f>>& positions);

}  // namespace beatlas::assess
