#pragma once

namespace beatlas {

/// Slices this far apart [mm] cannot be followed one into the next: segmentation treats each alone
/// and the workspace interpolates their outlines instead of their coverage.
inline constexpr double kThickSlicesMm = 5.0;

}  // namespace beatlas
