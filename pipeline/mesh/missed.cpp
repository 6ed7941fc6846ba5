#include "pipeline/mesh/missed.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "pipeline/field/closest_triangle.h"

namespace beatlas::mesh {
namespace {

/// Whether a closed surface holds a point: a ray from it along an axis leaves it once more than it
/// enters. The ray is moved a little, so that none goes through an edge of a surface on the
/// lattice.
bool holds(const std::vector<Vec3>& points, const std::vector<Triangle>& triangles, Vec3 from,
           Eigen::Index axis) {
  constexpr double kAsideMm = 1e-5;
  const Eigen::Index u = (axis + 1) % 3;
  const Eigen::Index v = (axis + 2) % 3;
  from[u] += kAsideMm;
  from[v] += kAsideMm / 3;
  bool inside = false;
  for (const Triangle& t : triangles) {
    std::array<Vec3, 3> corner;
    for (std::size_t n = 0; n < 3; ++n) corner[n] = points[t[n]] - from;
    const auto turn = [&](std::size_t a, std::size_t b) {
      return corner[a][u] * corner[b][v] - corner[a][v] * corner[b][u];
    };
    const Vec3 weight(turn(1, 2), turn(2, 0), turn(0, 1));
    const bool across = (weight.array() > 0).all() || (weight.array() < 0).all();
    if (!across) continue;
    const double ahead =
        weight[0] * corner[0][axis] + weight[1] * corner[1][axis] + weight[2] * corner[2][axis];
    if (ahead * weight.sum() > 0) inside = !inside;
  }
  return inside;
}

}  // namespace

double missed_share(const Grid& grid, const std::vector<float>& distances,
                    const std::vector<Vec3>& points, const std::vector<Triangle>& triangles,
                    double reach_mm) {
  const field::ClosestTriangle mesh({points, triangles});
  const auto reach2 = static_cast<float>(reach_mm * reach_mm);
  const int apart = std::max(1, static_cast<int>(std::lround(reach_mm / grid.spacing_mm().x())));
  std::size_t looked_at = 0;
  std::size_t missed = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::array<std::size_t, 2> across{(axis + 1) % 3, (axis + 2) % 3};
    Index3 at{0, 0, 0};
    for (at[across[1]] = 0; at[across[1]] < grid.size[across[1]]; at[across[1]] += apart) {
      for (at[across[0]] = 0; at[across[0]] < grid.size[across[0]]; at[across[0]] += apart) {
        at[axis] = 0;
        float before = distances[grid.offset(at[0], at[1], at[2])];
        for (at[axis] = 1; at[axis] < grid.size[axis]; ++at[axis]) {
          const float here = distances[grid.offset(at[0], at[1], at[2])];
          const float last = std::exchange(before, here);
          if ((last < 0) == (here < 0)) continue;
          Vec3 index(at[0], at[1], at[2]);
          index[static_cast<Eigen::Index>(axis)] -= static_cast<double>(here / (here - last));
          const Vec3 mm = grid.mm_from_index * index;
          ++looked_at;
          if (mesh.nearest(mm, {reach2}).distance2_mm2 < reach2) continue;
          if (!holds(points, triangles, mm, static_cast<Eigen::Index>(axis))) ++missed;
        }
      }
    }
  }
  return looked_at > 0 ? static_cast<double>(missed) / static_cast<double>(looked_at) : 0;
}

}  // namespace beatlas::mesh
