#pragma once
/// Segmentations of bodies whose volume and surface are known in closed form.

#include <cmath>
#include <functional>
#include <numbers>

#include "pipeline/core/box_share.h"
#include "pipeline/core/shapes.h"
#include "runtime/base/error.h"

namespace beatlas::shape::made {

inline Grid straight_grid(const Index3& size, const Vec3& spacing_mm) {
  Grid grid{size, Affine::Identity()};
  grid.mm_from_index.linear() = spacing_mm.asDiagonal();
  return grid;
}

inline Grid oblique_grid(const Index3& size, const Vec3& spacing_mm, const Vec3& middle_lps) {
  Grid grid = straight_grid(size, spacing_mm);
  grid.mm_from_index.linear() =
      (Eigen::AngleAxisd(0.5, Vec3::UnitZ()) * Eigen::AngleAxisd(-0.35, Vec3::UnitY()) *
       Eigen::AngleAxisd(0.7, Vec3::UnitX()))
          .toRotationMatrix() *
      grid.mm_from_index.linear();
  const Vec3 middle = 0.5 * Vec3(size[0] - 1, size[1] - 1, size[2] - 1);
  grid.mm_from_index.translation() = middle_lps - grid.mm_from_index.linear() * middle;
  return grid;
}

inline double ball_ml(double radius_mm) {
  return 4.0 / 3.0 * std::numbers::pi * radius_mm * radius_mm * radius_mm * 1e-3;
}

/// Coverage of a ball, its surface taken as flat in parts of a voxel no longer than 1 mm.
inline std::vector<float> ball_coverage(const Grid& grid, const Vec3& centre_lps,
                                        double radius_mm) {
  const Vec3 spacing = grid.spacing_mm();
  const Eigen::Matrix3d axes = grid.mm_from_index.linear().colwise().normalized();
  const Vec3 parts = spacing.array().ceil();
  const Vec3 half = 0.5 * spacing.cwiseQuotient(parts);
  std::vector<float> coverage(grid.count());
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        float& out = coverage[grid.offset(i, j, k)];
        const double away = (grid.mm(i, j, k) - centre_lps).norm() - radius_mm;
        if (std::abs(away) > 0.5 * spacing.norm()) {
          out = away < 0 ? 1.0F : 0.0F;
          continue;
        }
        double sum = 0;
        for (int c = 0; c < parts[2]; ++c) {
          for (int b = 0; b < parts[1]; ++b) {
            for (int a = 0; a < parts[0]; ++a) {
              const Vec3 x = grid.mm(i + (a + 0.5) / parts[0] - 0.5, j + (b + 0.5) / parts[1] - 0.5,
                                     k + (c + 0.5) / parts[2] - 0.5) -
                             centre_lps;
              sum += box_share(half, x.norm() - radius_mm, axes.transpose() * x.normalized());
            }
          }
        }
        out = static_cast<float>(sum / parts.prod());
      }
    }
  }
  return coverage;
}

/// A segmentation whose coverage spans the whole stack; labels are left empty but for their grid.
inline Segmentation segmentation_of(const Grid& grid, int phases) {
  Segmentation out;
  out.labels.grid = grid;
  out.coverage.grid = grid;
  out.labels.phases.assign(static_cast<std::size_t>(phases), {});
  return out;
}

/// Trilinear value of a shape's level at a point of the workspace.
inline double level_at(const ShapeCycle& shape, std::size_t phase, const Vec3& at) {
  const Grid& grid = shape.level.grid;
  const Vec3 x = grid.mm_from_index.inverse() * at;
  const Vec3 low = x.array().floor();
  const Vec3 f = x - low;
  double sum = 0;
  for (int n = 0; n < 8; ++n) {
    const int a = n & 1;
    const int b = (n >> 1) & 1;
    const int c = n >> 2;
    const double w = (a ? f[0] : 1 - f[0]) * (b ? f[1] : 1 - f[1]) * (c ? f[2] : 1 - f[2]);
    if (w == 0) continue;
    sum += w * shape.level.phases[phase][grid.offset(static_cast<int>(low[0]) + a,
                                                     static_cast<int>(low[1]) + b,
                                                     static_cast<int>(low[2]) + c)];
  }
  return sum;
}

/// Distance from `from` along unit `direction` to where the level turns positive.
inline double surface_along(const ShapeCycle& shape, std::size_t phase, const Vec3& from,
                            const Vec3& direction, double low, double high) {
  while (high - low > 1e-4) {
    const double middle = 0.5 * (low + high);
    (level_at(shape, phase, from + middle * direction) < 0 ? low : high) = middle;
  }
  return low;
}

/// Volume of the negative part [ml], by 4 x 4 x 4 points a lattice cell.
inline double volume_ml(const ShapeCycle& shape, std::size_t phase) {
  const Grid& grid = shape.level.grid;
  constexpr int kSteps = 4;
  double inside = 0;
  for (int k = 0; k + 1 < grid.size[2]; ++k) {
    for (int j = 0; j + 1 < grid.size[1]; ++j) {
      for (int i = 0; i + 1 < grid.size[0]; ++i) {
        bool negative = false;
        bool positive = false;
        for (int n = 0; n < 8; ++n) {
          const float v =
              shape.level.phases[phase][grid.offset(i + (n & 1), j + ((n >> 1) & 1), k + (n >> 2))];
          (v < 0 ? negative : positive) = true;
        }
        if (!negative) continue;
        if (!positive) {
          inside += 1;
          continue;
        }
        for (int c = 0; c < kSteps; ++c) {
          for (int b = 0; b < kSteps; ++b) {
            for (int a = 0; a < kSteps; ++a) {
              const Vec3 at =
                  grid.mm(i + (a + 0.5) / kSteps, j + (b + 0.5) / kSteps, k + (c + 0.5) / kSteps);
              inside += (level_at(shape, phase, at) < 0) / std::pow(kSteps, 3);
            }
          }
        }
      }
    }
  }
  return inside * grid.voxel_ml();
}

}  // namespace beatlas::shape::made
