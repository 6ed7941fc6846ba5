#pragma once
#include "runtime/base/geometry.h"

namespace beatlas {

/// Weights of the corners in the point of a triangle that is nearest to p (Ericson, Real-Time
/// Collision Detection, 2005, 5.1.5: by the region of the plane that p lies over); of a triangle
/// without an area a point of it.
[[nodiscard]] Vec3 nearest_of_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace beatlas
