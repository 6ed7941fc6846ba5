#pragma once
/// Where a straight line runs inside a body made of ellipsoids and horizontal planes, in closed
/// form: the line crosses each primitive where a quadratic is zero, and between two neighbouring
/// crossings it is wholly inside or wholly outside. Points `origin + s * direction`, `direction` of
/// unit length, s and all lengths [mm].

#include <functional>
#include <vector>

#include "pipeline/phantom/phantom.h"
#include "pipeline/phantom/solid.h"

namespace beatlas::phantom {

/// A part of a line, from_mm < to_mm.
struct Span {
  double from_mm = 0;
  double to_mm = 0;
  [[nodiscard]] double length_mm() const { return to_mm - from_mm; }
};

/// The s at which the line crosses a primitive, ascending; none where it only touches. A semi-axis
/// may be infinite: a cylinder, which a line along its axis never crosses.
[[nodiscard]] std::vector<double> crossings(const Primitive& primitive, const Vec3& origin,
                                            const Vec3& direction);

/// The parts of [within.from_mm, within.to_mm] inside, ascending; parts that meet are joined.
/// @param contains of the body whose boundary lies on `primitives`; asked once between crossings.
[[nodiscard]] std::vector<Span> spans_inside(const std::vector<Primitive>& primitives,
                                             const std::function<bool(const Vec3&)>& contains,
                                             const Vec3& origin, const Vec3& direction,
                                             const Span& within);
[[nodiscard]] std::vector<Span> spans_inside(const Solid& solid, const Vec3& origin,
                                             const Vec3& direction, const Span& within);

/// The parts in the muscle of the left ventricle; origin and direction patient LPS.
/// @param anatomy that of the frame's phantom, for where the heart lies
[[nodiscard]] std::vector<Span> spans_in_lv_muscle(const Frame& frame, const Anatomy& anatomy,
                                                   const Vec3& origin_lps,
                                                   const Vec3& direction_lps, const Span& within);

}  // namespace beatlas::phantom
