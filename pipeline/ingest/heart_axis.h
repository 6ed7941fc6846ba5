#pragma once
/// Which planes of an exam lie across the left ventricle's axis, as far as its views tell.

#include <vector>

#include "pipeline/ingest/plane_groups.h"

namespace beatlas::ingest {

/// Two planes are turned against each other, not the same one planned again [degrees].
inline constexpr double kTurnedDeg = 30;

/// How well the views meet along a plane's normal, 0 to 1: over all pairs of views, each weighed by
/// how far its two are turned against each other, the share of those that both hold the normal. 0
/// if no two views tell. Views are planes of its frame of reference with ordinary cines of fewer
/// slices than a stack has, which were planned through the left ventricle's axis; of those of one
/// direction one counts, and of those parallel to the plane none.
///
/// A stack that lies so is the short axis; volumes are taken from it (Kramer et al., J Cardiovasc
/// Magn Reson 2020;22:17, doi:10.1186/s12968-020-00607-1), however many axial slices lie beside it.
[[nodiscard]] double axis_evidence(const Plane& plane, const std::vector<Plane>& planes);

/// "axial", "coronal", "sagittal" if the normal is within 15 degrees of a patient's axis, else
/// "oblique", as a short axis nearly always is.
[[nodiscard]] const char* orientation_told(const Plane& plane);
[[nodiscard]] bool is_oblique(const Plane& plane);

/// Whether two planes are of one direction: their normals are within 15 degrees.
[[nodiscard]] bool one_direction(const Plane& a, const Plane& b);

/// Whether two planes are turned against each other by kTurnedDeg and more.
[[nodiscard]] bool turned(const Plane& a, const Plane& b);

}  // namespace beatlas::ingest
