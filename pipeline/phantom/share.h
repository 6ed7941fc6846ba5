#pragma once
/// The share of a voxel's box on one side of a plane, as an image with blur shows it.

#include "runtime/base/geometry.h"

namespace beatlas::phantom {

/// box_share of a box blurred by a Gaussian of standard deviations sigma_mm along the axes, any of
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
