#pragma once
#include <filesystem>

#include "pipeline/core/shapes.h"
#include "pipeline/core/stage_context.h"

namespace beatlas::field {

struct FieldOptions {
  double voxel_mm = 1.5;  ///< [mm] 0.5..4
  double inner_mm = 15;   ///< [mm] 3..40: depth inside to which distances are kept
  double outer_mm = 6;    ///< [mm] 3..40
};

/// Narrow-band signed distance to the zero surface of a level function: OpenVDB's contour of the
/// level, made exact to the samples' cubic interpolant, and the exact distance to its triangles.
/// Samples lie at origin + voxel_mm * (i, j, k), axes along the workspace, one lattice for all
/// phases that holds every phase's surface and outer_mm around it. The sign is right everywhere; a
/// cavity enclosed by the structure is outside. A shape that its lattice cuts is closed half a
/// sample beyond it, and the log says so.
/// Error against closed form in a 3 mm band, level at 1 mm: mean 0.003 mm from exact levels at
/// 25 mm radius, 0.04 mm (bias 0.01) from bare coverage of voxels.
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
