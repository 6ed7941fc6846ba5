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

/// Narrow-band signed distance to the zero surface of a level function (OpenVDB).
/// @throws Error{InvalidInput} if a phase of the shape has no surface.
[[nodiscard]] FieldCycle build_field(const ShapeCycle& shape, const FieldOptions& options,
                                     StageContext& context);

/// One .vdb file: a FloatGrid "<structure>_<phase>" a phase with the clamp and volumes as
/// metadata; read_vdb(write_vdb(x)) == x. @throws Error{Machine} / Error{InvalidInput}.
void write_vdb(const std::filesystem::path& file, const FieldCycle& field);
[[nodiscard]] FieldCycle read_vdb(const std::filesystem::path& file);

}  // namespace beatlas::field
