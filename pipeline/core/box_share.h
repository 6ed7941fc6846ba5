#pragma once
/// The share of a voxel's box on one side of a plane.

#include "runtime/base/geometry.h"

namespace beatlas {

/// Share of the box centre +- half_mm (edges along the axes) on the inner side of a plane at
/// signed distance `distance_mm` from the centre (negative: the centre is inside) with unit normal
/// `outward`. Closed form (volume of a cut cube, Scardovelli & Zaleski 2000), error below 1e-5.
[[nodiscard]] double box_share(const Vec3& half_mm, double distance_mm, const Vec3& outward);

/// The same of a box about the origin in which normal . x < offset, as a sum over its corners.
/// @param normal of length 1
[[nodiscard]] double share_below(const Vec3& normal, const Vec3& half, double offset);

}  // namespace beatlas
