#pragma once
#include <string>

#include "pipeline/assess/validate.h"

namespace beatlas::cli {

/// Tables of at most 100 columns: shapes, motion and wall, force; then what failed.
[[nodiscard]] std::string validation_to_text(const assess::ValidationReport& report);

/// Vertices of drawn surfaces at end-diastole and end-systole and how far off each lies: columns
/// structure, phase, x_mm, y_mm, z_mm, nx, ny, nz (workspace, normals outward), area_mm2, off_mm.
[[nodiscard]] std::string vertices_to_csv(const assess::ValidationReport& report);

}  // namespace beatlas::cli
