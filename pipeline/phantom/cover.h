#pragma once
/// The share of every voxel that lies in a body, from the body's exact distance.

#include <array>
#include <functional>
#include <vector>

#include "pipeline/core/grid.h"
#include "pipeline/phantom/thorax.h"

namespace beatlas::phantom {

/// Share of the box centre +- half_mm (edges along the axes) on the inner side of a plane at
/// signed distance `distance_mm` from the centre (negative: the centre is inside) with unit normal
/// `outward`. Closed form (volume of a cut cube, Scardovelli & Zaleski 2000), error below 1e-5.
[[nodiscard]] double box_share(const Vec3& half_mm, double distance_mm, const Vec3& outward);

/// Signed distance of a body with its gradient, at any point of the grid's frame [mm].
using Body = std::function<SignedPlane(const Vec3&)>;

inline constexpr int kMostBodies = 8;
using Shares = std::array<float, kMostBodies>;

/// A block of voxels.
struct Block {
  Index3 first{0, 0, 0};
  Index3 size{0, 0, 0};
};

struct CoverOptions {
  double thickness_mm = 0;     ///< edge of a voxel's box along k; 0 = the spacing
  bool partial_volume = true;  ///< false: 0 or 1 by the voxel's centre
  /// Boxes with longer edges are cut into equal parts, as their piece of surface is taken as flat:
  /// for a radius of curvature R the error is below edge^2 / (24 R).
  double flat_mm = 1.5;
};

/// Finds the shares of every voxel of `block` in every body and hands them to `emit`, for whole
/// blocks of voxels that are all inside or all outside of each body, else for single voxels (then
/// `whole` is false). Far from surfaces blocks are settled at once: a distance is 1-Lipschitz.
/// @pre the grid's axes are perpendicular; at most kMostBodies bodies
void cover(const Grid& grid, const Block& block, const std::vector<Body>& bodies,
           const CoverOptions& options,
           const std::function<void(const Block&, const Shares&, bool whole)>& emit);

/// The blocks of at most `edge` voxels a side that make up a grid.
[[nodiscard]] std::vector<Block> blocks_of(const Grid& grid, const Index3& edge);

}  // namespace beatlas::phantom
