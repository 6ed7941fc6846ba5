#pragma once
/// Voxels face to face.

#include "pipeline/core/box.h"

namespace beatlas {

/// Calls visit(voxel) for each voxel of the grid that shares a face with one, all offsets in it.
template <class Visit>
void for_faces(const Grid& grid, std::size_t voxel, const Visit& visit) {
  const Index3 at = index_of(grid, voxel);
  for (int axis = 0; axis < 3; ++axis) {
    for (const int step : {-1, 1}) {
      Index3 next = at;
      next[axis] += step;
      if (grid.contains(next[0], next[1], next[2])) {
        visit(grid.offset(next[0], next[1], next[2]));
      }
    }
  }
}

}  // namespace beatlas
