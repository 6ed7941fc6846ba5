#pragma once
/// Vocabulary of geometry. Frames are named in variable names:
/// `lps` patient, DICOM LPS [mm]; `workspace` paper A's absolute workspace [mm];
/// `index` voxel indices (i, j, k), integers at voxel centres. `a_from_b` maps b to a.

#include <array>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace beatlas {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Vec3f = Eigen::Vector3f;
using Affine = Eigen::Affine3d;  ///< `a_from_b * point_in_b`
using Index3 = std::array<int, 3>;

inline constexpr double kMmPerM = 1000;

/// Paper A's workspace: 256 x 256 x 64 voxels of 1 x 1 x 3 mm, origin at its corner.
inline constexpr Index3 kWorkspaceSize{256, 256, 64};
inline constexpr std::array<double, 3> kWorkspaceSpacingMm{1.0, 1.0, 3.0};
inline constexpr std::array<double, 3> kWorkspaceExtentMm{256.0, 256.0, 192.0};
/// Where the time-mean centroid of the heart is put for a source that is not paper A's grid.
inline constexpr std::array<double, 3> kWorkspaceCentreMm{128.0, 128.0, 96.0};

}  // namespace beatlas
