#pragma once
/// A structure's surface as points with normals and areas, and patches of them.

#include <cstdint>
#include <vector>

#include "pipeline/core/grid.h"

namespace beatlas::alarm {

struct SurfacePoint {
  Index3 voxel{};                  ///< the voxel inside that the point belongs to
  Vec3 index = Vec3::Zero();       ///< where the smoothed surface passes, grid index, fractional
  Vec3 outward_mm = Vec3::Zero();  ///< unit normal along the grid's axes
  double area_mm2 = 0;
};

/// One point for each voxel of `inside` (not 0) that has a face on the surface. Slices thinner
/// than kThickSlicesMm make one body; thicker ones stand alone and only their outlines count. The
/// border of the grid is no surface.
[[nodiscard]] std::vector<SurfacePoint> surface_points(const Grid& grid,
                                                       const std::vector<std::uint8_t>& inside);

/// Of each list, a value a point: the mean over the surface around each point, Gaussian of 2.5 mm.
[[nodiscard]] std::vector<std::vector<float>> averaged_over_surface(
    const Grid& grid, const std::vector<SurfacePoint>& points,
    std::vector<std::vector<float>> values);

struct Patch {
  double area_mm2 = 0;
  std::size_t middle = 0;  ///< the point nearest to the patch's centre
  std::vector<std::size_t> points;
};

/// The largest connected patch of the points for which `chosen` is not 0; area 0 if there is none.
[[nodiscard]] Patch largest_patch(const Grid& grid, const std::vector<SurfacePoint>& points,
                                  const std::vector<std::uint8_t>& chosen);

/// Points of a patch that lie evenly over it: its middle, then each time the one farthest from
/// those before, at most `most` and none nearer to another than `apart_mm`.
[[nodiscard]] std::vector<std::size_t> spread_over(const Patch& patch, const Grid& grid,
                                                   const std::vector<SurfacePoint>& points,
                                                   std::size_t most, double apart_mm);

}  // namespace beatlas::alarm
