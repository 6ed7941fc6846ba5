#pragma once
/// Shapes whose distance and volume are known without any of the code under test.

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "pipeline/core/shapes.h"

namespace beatlas::closed_form {

/// An ellipsoid with axes along x, y, z.
struct Ellipsoid {
  Vec3 centre_mm = Vec3::Zero();
  Vec3 radii_mm = Vec3::Ones();

  [[nodiscard]] bool holds(const Vec3& x) const {
    return (x - centre_mm).cwiseQuotient(radii_mm).squaredNorm() < 1;
  }
  [[nodiscard]] double volume_ml() const {
    return 4.0 / 3.0 * std::numbers::pi * radii_mm.prod() * 1e-3;
  }

  /// Signed distance, negative inside: the nearest point solves
  /// sum (r_i p_i / (t + r_i^2))^2 = 1 (Eberly, Distance from a point to an ellipsoid), by
  /// bisection on the largest root.
  [[nodiscard]] double distance_mm(const Vec3& x) const {
    const Vec3 p = (x - centre_mm).cwiseAbs().cwiseMax(1e-9);
    const Vec3 r2 = radii_mm.cwiseAbs2();
    const auto f = [&](double t) {
      return (radii_mm.cwiseProduct(p).array() / (t + r2.array())).square().sum() - 1.0;
    };
    Eigen::Index least = 0;
    radii_mm.minCoeff(&least);
    double low = -r2[least] + radii_mm[least] * p[least];
    double high = -r2[least] + radii_mm.cwiseProduct(p).norm();
    for (int n = 0; n < 80; ++n) {
      const double middle = 0.5 * (low + high);
      (f(middle) > 0 ? low : high) = middle;
    }
    const Vec3 foot = (r2.array() * p.array() / (0.5 * (low + high) + r2.array())).matrix();
    const double distance = (p - foot).norm();
    return p.cwiseQuotient(radii_mm).squaredNorm() < 1 ? -distance : distance;
  }
};

/// A cubic lattice of `mm` voxels over a box, shifted off round numbers so that no sample is
/// placed well by chance.
inline Grid lattice(const Vec3& low_mm, const Vec3& high_mm, double mm) {
  Grid grid;
  for (int axis = 0; axis < 3; ++axis) {
    grid.size[static_cast<std::size_t>(axis)] =
        static_cast<int>(std::ceil((high_mm[axis] - low_mm[axis]) / mm)) + 1;
  }
  grid.mm_from_index.linear() = mm * Eigen::Matrix3d::Identity();
  grid.mm_from_index.translation() = low_mm + mm * Vec3(0.13, -0.29, 0.37);
  return grid;
}

using Level = std::function<double(const Vec3& mm)>;

inline std::vector<float> sampled(const Grid& grid, const Level& level) {
  std::vector<float> out(grid.count());
  std::size_t n = 0;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        out[n++] = static_cast<float>(level(grid.mm(i, j, k)));
      }
    }
  }
  return out;
}

/// 0.5 - the share of the voxel about each sample that lies inside, from `fine`^3 points a voxel.
/// Voxels farther than one edge from the surface by `distance_mm` are not divided.
inline std::vector<float> coverage_level(const Grid& grid, const Level& distance_mm,
                                         const std::function<bool(const Vec3& mm)>& is_inside,
                                         int fine) {
  const double mm = grid.spacing_mm().x();
  return sampled(grid, [&](const Vec3& x) {
    const double distance = distance_mm(x);
    if (std::abs(distance) > mm) return distance < 0 ? -0.5 : 0.5;
    int inside = 0;
    for (int c = 0; c < fine; ++c) {
      for (int b = 0; b < fine; ++b) {
        for (int a = 0; a < fine; ++a) {
          const Vec3 shift = Vec3(a + 0.5, b + 0.5, c + 0.5) / fine - Vec3::Constant(0.5);
          inside += is_inside(x + mm * shift) ? 1 : 0;
        }
      }
    }
    return 0.5 - static_cast<double>(inside) / (fine * fine * fine);
  });
}

}  // namespace beatlas::closed_form
