#pragma once
#include <iosfwd>
#include <optional>
#include <string>

#include "runtime/atlas/surface_band.h"
#include "runtime/field/field_query.h"

namespace beatlas::app {

struct ProbeOptions {
  double stiffness_n_per_m = 150;
  bool lps = false;  ///< points in, normals and forces out are in patient LPS
  Affine workspace_from_lps = Affine::Identity();  ///< used if `lps`; rigid
  std::optional<atlas::BandQuery> band;            ///< of the structure, where it is known
};

/// For every row of a CSV with columns x_mm, y_mm, z_mm, t_s (in any order, others are carried
/// along) the same row and distance_mm, nx, ny, nz, velocity_mm_s, fx_n, fy_n, fz_n: signed
/// distance, outward unit normal, velocity of the surface along it, and the force
/// K max(0, -distance) n before any cap. Time is taken modulo the R-R interval.
///
/// Outside the band the sign is right, the magnitude clamped and the velocity 0; n points away from
/// the structure's centre there (and is zero at the centre itself).
///
/// With a band two columns follow: band_mm, how far the true surface may lie from where it is, in
/// or out, with 90 % (BandQuery at the point's own place, so ask it on the surface or near it), and
/// band_n, what that is in force while the point is inside: K band_mm.
/// @param name of the points' file, for messages.
/// @throws Error{InvalidInput} naming line and column.
void probe(const field::FieldQuery& field, const ProbeOptions& options, std::istream& points,
           const std::string& name, std::ostream& out);

}  // namespace beatlas::app
