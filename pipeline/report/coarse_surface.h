#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipeline/core/shapes.h"

namespace beatlas::report {

/// A surface with fewer vertices, which are some of the surface's own, so that they move as those
/// do.
struct CoarseSurface {
  Structure structure{};
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::vector<Vec3f>> positions;  ///< [phase][vertex], workspace [mm]
};

/// Vertices are taken off (VTK's decimation, which keeps closed surfaces closed and makes no new
/// vertex) where the surface of `phase` stays nearest to what it was, until about `vertices` are
/// left. A surface that has no more is given back whole.
[[nodiscard]] CoarseSurface coarse_surface(const SurfaceCycle& surface, std::size_t vertices,
                                           int phase);

}  // namespace beatlas::report
