#pragma once

namespace beatlas {

/// Slices this far apart [mm] cannot be followed one into the next: segmentation treats each alone
/// and the workspace interpolates their outlines instead of their coverage.
inline constexpr double kThickSlicesMm = 5.0;

/// Whether slices so far apart [mm] are thick ones. Places of slices in a file are rounded: 5 mm
/// comes out of an oblique stack as 4.9999998 or 5.0000002, and the same exam from another kind of
/// file as the other.
[[nodiscard]] constexpr bool are_thick_slices(double apart_mm) {
  return apart_mm > kThickSlicesMm - 0.01;
}

}  // namespace beatlas
