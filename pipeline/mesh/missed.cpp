#include "pipeline/mesh/missed.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "pipeline/field/closest_triangle.h"

namespace beatlas::mesh {
namespace {

/// Where a closed surface meets lines of a lattice along one axis: a point of a line from which
/// the surface is met an odd number of times lies in it.
class Meetings {
 public:
  /// @param index points of the surface [voxel]
  /// @param apart how far apart the lines lie [voxel]; the first goes through the first voxel
  Meetings(const std::vector<Vec3>& index, const std::vector<Triangle>& triangles, Index3 size,
           std::size_t axis, int apart)
      : axis_(static_cast<Eigen::Index>(axis)), apart_(apart) {
    for (std::size_t n = 0; n < 2; ++n) {
      across_[n] = static_cast<Eigen::Index>((axis + 1 + n) % 3);
      lines_[n] = (size[(axis + 1 + n) % 3] - 1) / apart + 1;
    }
    at_.resize(static_cast<std::size_t>(lines_[0]) * static_cast<std::size_t>(lines_[1]));
    for (const Triangle& t : triangles) meet({index[t[0]], index[t[1]], index[t[2]]});
  }

  /// @param from [voxel], on one of the lines
  [[nodiscard]] bool hold(const Index3& line, double from) const {
    const std::vector<double>& at =
        at_[number(line[static_cast<std::size_t>(across_[0])] / apart_,
                   line[static_cast<std::size_t>(across_[1])] / apart_)];
    return std::count_if(at.begin(), at.end(), [&](double there) { return there > from; }) % 2 == 1;
  }

 private:
  [[nodiscard]] std::size_t number(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(lines_[0]) +
           static_cast<std::size_t>(u);
  }

  void meet(const std::array<Vec3, 3>& corner) {
    // The lines are moved a little, so that none goes through an edge of a surface on the lattice.
    constexpr std::array kAside{1e-5, 3e-6};
    std::array<int, 2> first{};
    std::array<int, 2> last{};
    for (std::size_t n = 0; n < 2; ++n) {
      const auto [least, most] =
          std::minmax({corner[0][across_[n]], corner[1][across_[n]], corner[2][across_[n]]});
      first[n] = std::max(0, static_cast<int>(std::ceil((least - kAside[n]) / apart_)));
      last[n] = std::min(lines_[n] - 1, static_cast<int>(std::floor((most - kAside[n]) / apart_)));
    }
    for (int v = first[1]; v <= last[1]; ++v) {
      for (int u = first[0]; u <= last[0]; ++u) {
        const std::array<double, 2> line{u * apart_ + kAside[0], v * apart_ + kAside[1]};
        const auto turn = [&](std::size_t a, std::size_t b) {
          return (corner[a][across_[0]] - line[0]) * (corner[b][across_[1]] - line[1]) -
                 (corner[a][across_[1]] - line[1]) * (corner[b][across_[0]] - line[0]);
        };
        const Vec3 weight(turn(1, 2), turn(2, 0), turn(0, 1));
        if (!((weight.array() > 0).all() || (weight.array() < 0).all())) continue;
        const Vec3 heights(corner[0][axis_], corner[1][axis_], corner[2][axis_]);
        at_[number(u, v)].push_back(weight.dot(heights) / weight.sum());
      }
    }
  }

  Eigen::Index axis_;
  std::array<Eigen::Index, 2> across_{};
  int apart_;
  std::array<int, 2> lines_{};
  std::vector<std::vector<double>> at_;  ///< [line] of its meetings [voxel]
};

/// Calls visit(at, crossed) for every place [voxel] where samples change sign along lines of one
/// axis, `apart` voxels from each other; `at` is the first voxel behind it.
template <class Visit>
void for_each_crossing(const Grid& grid, const std::vector<float>& distances, std::size_t axis,
                       int apart, const Visit& visit) {
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
        Vec3 crossed(at[0], at[1], at[2]);
        crossed[static_cast<Eigen::Index>(axis)] -= static_cast<double>(here / (here - last));
        visit(at, crossed);
      }
    }
  }
}

}  // namespace

double missed_share(const Grid& grid, const std::vector<float>& distances,
                    const std::vector<Vec3>& points, const std::vector<Triangle>& triangles,
                    double reach_mm) {
  const field::ClosestTriangle mesh({points, triangles});
  const auto reach2 = static_cast<float>(reach_mm * reach_mm);
  const int apart = std::max(1, static_cast<int>(std::lround(reach_mm / grid.spacing_mm().x())));
  const Affine index_from_mm = grid.mm_from_index.inverse(Eigen::Affine);
  std::vector<Vec3> index(points.size());
  std::transform(points.begin(), points.end(), index.begin(),
                 [&](const Vec3& mm) { return Vec3(index_from_mm * mm); });
  std::size_t looked_at = 0;
  std::size_t missed = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Meetings meetings(index, triangles, grid.size, axis, apart);
    for_each_crossing(grid, distances, axis, apart, [&](const Index3& at, const Vec3& crossed) {
      ++looked_at;
      if (meetings.hold(at, crossed[static_cast<Eigen::Index>(axis)])) return;
      const Vec3 mm = grid.mm_from_index * crossed;
      if (mesh.nearest(mm, {reach2}).distance2_mm2 >= reach2) ++missed;
    });
  }
  return looked_at > 0 ? static_cast<double>(missed) / static_cast<double>(looked_at) : 0;
}

}  // namespace beatlas::mesh
