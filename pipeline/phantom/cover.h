#pragma once
/// The share of every voxel that lies in a body, from the body's exact distance.

#include <array>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "pipeline/core/grid.h"
#include "pipeline/phantom/scanner.h"
#include "pipeline/phantom/share.h"
#include "pipeline/phantom/thorax.h"

namespace beatlas::phantom {

/// A body in the grid's frame [mm].
struct Body {
  /// Signed distance with its gradient, at any point.
  std::function<SignedPlane(const Vec3&)> surface;
  /// Whether a point is inside; agrees with the sign of the distance, and may be faster.
  std::function<bool(const Vec3&)> inside;
  /// The index of a body before this one that holds all of it; what is outside of that one is not
  /// looked at. -1: none.
  int within = -1;
  /// A ball that holds all of it.
  Vec3 ball_mm = Vec3::Zero();
  double ball_radius_mm = std::numeric_limits<double>::infinity();
};

inline constexpr int kMostBodies = 16;
using Shares = std::array<float, kMostBodies>;

/// A block of voxels.
struct Block {
  Index3 first{0, 0, 0};
  Index3 size{0, 0, 0};
};

struct CoverOptions {
  double thickness_mm = 0;  ///< edge of a voxel's box along k; 0 = the spacing
  PartialVolume partial_volume = PartialVolume::Exact;
  Vec3 sigma_mm = Vec3::Zero();  ///< of a Gaussian that blurs the box along i, j, k
  /// Boxes with longer edges are cut into equal parts, as their piece of surface is taken as flat:
  /// for a radius of curvature R it is misplaced by less than edge^2 / (24 R). Beyond the box by
  /// 1.5 standard deviations of a blur, where little of it reaches, one piece serves all.
  double flat_mm = 1.5;
};

/// Finds the shares of every voxel of `block` in every body and hands them to `emit`, for whole
/// blocks of voxels that are all inside or all outside of each body, and for single voxels.
/// Beyond kBlurSigmas of a blur they are 0 or 1.
///
/// Where a crease runs through a box of several parts (CoverOptions::flat_mm) its share is counted
/// over 400 points spread over box and blur, to about 0.02.
///
/// Far from surfaces blocks and runs of voxels are settled at once: a distance is 1-Lipschitz.
/// @pre the grid's axes are perpendicular; at most kMostBodies bodies
void cover(const Grid& grid, const Block& block, const std::vector<Body>& bodies,
           const CoverOptions& options,
           const std::function<void(const Block&, const Shares&)>& emit);

/// The blocks of at most `edge` voxels a side that make up a grid.
[[nodiscard]] std::vector<Block> blocks_of(const Grid& grid, const Index3& edge);

}  // namespace beatlas::phantom
