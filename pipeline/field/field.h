#pragma once
#include <filesystem>
#include <optional>

#include "pipeline/core/shapes.h"
#include "pipeline/core/stage_context.h"

namespace beatlas::field {

/// What becomes of noise that changes from phase to phase, see flicker.h. On `small` without noise
/// its removal takes 5 % off the LV's mean error and 10 % off the normals'.
enum class Flicker { Remove, Keep };

/// What becomes of pieces apart, hollows and handles: holes in thin places and threads between
/// parts. build_field closes those of one structure; for structures that touch build each with Keep
/// and call repair_topology on all of them.
enum class Handles { Close, Keep };

/// The defaults are from the front of `beatlas bench` on the phantom small, whole scene palpation.
struct FieldOptions {
  /// [mm] 0.5..4; none: see voxel_edge_mm.
  std::optional<double> voxel_mm = {};
  /// [mm] 3..40: depth inside to which distances are kept. A finger that goes deeper than it feels
  /// a wrong force (at 6 mm the mean error is 60 % more); 15 costs 5 % of the package over 10.
  double inner_mm = 15;
  /// [mm] 3..40: height outside. A point would do with 3, at 14 % less; a tool of 5 mm radius
  /// touches that far out.
  double outer_mm = 6;
  Flicker flicker = Flicker::Remove;
  Handles handles = Handles::Close;
};

/// [mm] Edge of the samples of a field from shapes on such a lattice: that of the options or, where
/// they name none, 1.5 of the lattice's, from 1.5 to 4. At 1.5 the normal's 95th percentile is 1.5
/// degrees and a package 2.1 MB; at 1 it is 0.9 degrees for 5.6 MB, at 2 2.2 degrees for 1.1 MB.
/// Mean distance and force hardly change.
[[nodiscard]] double voxel_edge_mm(double lattice_mm, const FieldOptions& options);

/// Narrow-band signed distance to the zero surface of a level function: OpenVDB's contour of the
/// level, made exact to the samples' cubic interpolant, and the exact distance to its triangles.
/// Samples lie at origin + voxel_mm * (i, j, k), axes along the workspace, one lattice for all
/// phases that holds every phase's surface and outer_mm around it. The sign is right everywhere;
/// with Handles::Keep a cavity enclosed by the structure is outside. A shape that its lattice cuts
/// is closed half a sample beyond it, and the log says so. Error against closed form in a 3 mm
/// band, level at 1 mm: mean 0.003 mm from exact levels at 25 mm radius, 0.04 mm (bias 0.01) from
/// bare coverage of voxels.
/// @throws Error{Usage} for options out of range or a band narrower than two voxels;
/// Error{InvalidInput} if a phase of the shape has no surface, holds values that are not finite, or
/// the lattice is not isotropic; Error{Machine} if stopped.
[[nodiscard]] FieldCycle build_field(const ShapeCycle& shape, const FieldOptions& options,
                                     StageContext& context);

/// One .vdb file: a FloatGrid "<structure>_<phase>" a phase with the clamp and volumes as
/// metadata; read_vdb(write_vdb(x)) == x. @throws Error{Machine} / Error{InvalidInput}.
void write_vdb(const std::filesystem::path& file, const FieldCycle& field);
[[nodiscard]] FieldCycle read_vdb(const std::filesystem::path& file);

}  // namespace beatlas::field
