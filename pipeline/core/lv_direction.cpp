#include "pipeline/core/lv_direction.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Dense>
#include <Eigen/Eigenvalues>

namespace beatlas {
namespace {

/// Of the cavity's wall: how much of it faces each way, and the way that all of it together faces.
struct Wall {
  Eigen::Matrix3d facing = Eigen::Matrix3d::Zero();  ///< sum of area times n n^T
  Vec3 outward = Vec3::Zero();                       ///< sum of area times n, towards the muscle
};

/// As if sampled as coarsely along every axis as along the coarsest: where slices are thick, the
/// wall of a ventricle that leans has its steps along them spread over as much of a slice as it
/// shifts.
std::vector<float> sampled_alike(const Grid& grid, std::vector<float> share) {
  const Vec3 spacing = grid.spacing_mm();
  for (std::size_t a = 0; a < 3; ++a) {
    const auto reach = static_cast<int>(
        std::lround(0.5 * (spacing.maxCoeff() / spacing[static_cast<Eigen::Index>(a)] - 1)));
    if (reach == 0) continue;
    const std::size_t stride = a == 0   ? 1
                               : a == 1 ? static_cast<std::size_t>(grid.size[0])
                                        : grid.slice_count();
    const int count = grid.size[a];
    std::vector<double> up_to(static_cast<std::size_t>(count) + 1);  // sums along a line
    for (std::size_t v = 0; v < share.size(); ++v) {
      if (v / stride % static_cast<std::size_t>(count) != 0) continue;
      for (std::size_t n = 0; n + 1 < up_to.size(); ++n) {
        up_to[n + 1] = up_to[n] + static_cast<double>(share[v + n * stride]);
      }
      for (int n = 0; n < count; ++n) {
        const auto first = static_cast<std::size_t>(std::max(0, n - reach));
        const auto end = static_cast<std::size_t>(std::min(count, n + reach + 1));
        share[v + static_cast<std::size_t>(n) * stride] =
            static_cast<float>((up_to[end] - up_to[first]) / (2 * reach + 1));
      }
    }
  }
  return share;
}

/// What lies face to face with a voxel, all six together.
struct Beside {
  Vec3 step = Vec3::Zero();  ///< of the cavity's share, a voxel on along each axis
  double other = 0;          ///< sum of what is not the cavity
  double wall = 0;           ///< sum of what is muscle
};

Beside look_beside(const Grid& grid, const std::vector<float>& blood,
                   const std::vector<float>& muscle, const Index3& voxel) {
  const auto at = [&](const std::vector<float>& share, const Index3& i) {
    if (!grid.contains(i[0], i[1], i[2])) return 0.0;
    return static_cast<double>(share[grid.offset(i[0], i[1], i[2])]);
  };
  Beside out;
  for (std::size_t a = 0; a < 3; ++a) {
    std::array<double, 2> cavity{};
    for (const std::size_t side : {0, 1}) {
      Index3 n = voxel;
      n[a] += side == 0 ? -1 : 1;
      cavity[side] = at(blood, n);
      out.other += 1 - cavity[side];
      out.wall += at(muscle, n);
    }
    out.step[static_cast<Eigen::Index>(a)] = 0.5 * (cavity[1] - cavity[0]);
  }
  return out;
}

Wall wall_of(const Grid& grid, const std::vector<float>& blood, const std::vector<float>& muscle) {
  const Eigen::Matrix3d mm_from_step = grid.mm_from_index.linear().inverse().transpose();
  Wall out;
  // Voxels right beyond the grid have neighbours in it, too.
  for (int k = -1; k <= grid.size[2]; ++k) {
    for (int j = -1; j <= grid.size[1]; ++j) {
      for (int i = -1; i <= grid.size[0]; ++i) {
        const Beside found = look_beside(grid, blood, muscle, {i, j, k});
        if (found.step.isZero() || !(found.wall > 0) || !(found.other > 0)) continue;
        const Vec3 area = -std::min(1.0, found.wall / found.other) * (mm_from_step * found.step);
        out.facing += area * area.transpose() / area.norm();
        out.outward += area;
      }
    }
  }
  return out;
}

}  // namespace

std::optional<Vec3> lv_direction(const Grid& grid, const std::vector<float>& blood,
                                 const std::vector<float>& muscle) {
  const Wall wall = wall_of(grid, sampled_alike(grid, blood), sampled_alike(grid, muscle));
  if (!(wall.facing.trace() > 0)) return {};
  const Vec3 along =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(wall.facing).eigenvectors().col(0);
  return along.dot(wall.outward) > 0 ? Vec3(-along) : along;
}

bool cuts_across(const Grid& grid, const Vec3& direction) {
  constexpr double kAsMuch = 0.70710678;  // cosine of 45 degrees
  return std::abs(direction.dot(grid.mm_from_index.linear().col(2).normalized())) >= kAsMuch;
}

}  // namespace beatlas
