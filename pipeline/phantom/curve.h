#pragma once
/// One point on the curve in which two ellipsoids meet; the curve itself is followed by
/// intersection_curves (solid.h).

#include "pipeline/phantom/quadric.h"

namespace beatlas::phantom {

/// Moves x onto both surfaces by the shortest steps of Newton's method.
/// @return false where they touch instead of crossing, or x is too far off.
[[nodiscard]] bool settle_on_curve(const Ellipsoid& a, const Ellipsoid& b, Vec3& x);

/// Moves x to where three ellipsoids meet. @return false if Newton's method finds no such point.
[[nodiscard]] bool settle_on_corner(const Ellipsoid& a, const Ellipsoid& b, const Ellipsoid& c,
                                    Vec3& x);

/// Unit tangent of the curve at x.
[[nodiscard]] Vec3 curve_direction(const Ellipsoid& a, const Ellipsoid& b, const Vec3& x);

}  // namespace beatlas::phantom
