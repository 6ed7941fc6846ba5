#pragma once
/// The share of a voxel's box on one side of a plane.

#include "runtime/base/geometry.h"

namespace beatlas::phantom {

/// Share of the box centre +- half_mm (edges along the axes) on the inner side of a plane at
/// signed distance `distance_mm` from the centre (negative: the centre is inside) with unit normal
/// `outward`. Closed form (volume of a cut cube, Scardovelli & Zaleski 2000), error below 1e-5.
[[nodiscard]] double box_share(const Vec3& half_mm, double distance_mm, const Vec3& outward);

/// The same for a box blurred by a Gaussian of standard deviations sigma_mm along the axes, any of
/// which, as any edge, may be 0.
///
/// Along the normal n the blur is one Gaussian of variance sum n_i^2 sigma_i^2 and the box a sum of
/// uniform variables of half widths |n_i| half_i; their common distribution is a sum of integrals
/// of the normal one, in closed form. An edge less than half as wide as the Gaussian joins it with
/// its variance. Error below 5e-4, against integration. 0 or 1 beyond the box plus kBlurSigmas.
[[nodiscard]] double blurred_box_share(const Vec3& half_mm, const Vec3& sigma_mm,
                                       double distance_mm, const Vec3& outward);

/// Standard deviations at which a blur ends; 3e-5 of it lie beyond.
inline constexpr double kBlurSigmas = 4.0;

}  // namespace beatlas::phantom
