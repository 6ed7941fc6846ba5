#include "pipeline/core/long_axis.h"

namespace beatlas {

std::vector<float> LongAxis::heights_mm(const Grid& grid) const {
  std::vector<float> heights(grid.count());
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        heights[grid.offset(i, j, k)] = static_cast<float>(height_mm(grid.mm(i, j, k)));
      }
    }
  }
  return heights;
}

}  // namespace beatlas
