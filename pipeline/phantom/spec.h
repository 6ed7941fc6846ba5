#pragma once
/// Everything a phantom is made from. The same spec gives the same images, whatever the machine's
/// number of threads.

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "pipeline/core/grid.h"
#include "pipeline/phantom/anatomy.h"
#include "pipeline/phantom/scanner.h"

namespace beatlas::phantom {

struct PhantomSpec {
  std::string name = "adult";
  Grid grid;                        ///< imaging grid before `oblique_deg`; LPS
  Vec3 oblique_deg = Vec3::Zero();  ///< turns the grid about its centre: x, then y, then z [deg]
  int phases = 15;                  ///< 2..200, uniform in the R-R interval
  double rr_interval_s = 0.75;      ///< 0.2..3
  ScannerSpec scanner;
  Anatomy anatomy;

  /// The grid as imaged: `grid` turned by `oblique_deg`.
  [[nodiscard]] Grid imaging_grid() const;
};

/// The same view on another matrix: as many voxels of such a spacing about the grid's centre, axes
/// as they are. @param size 0s: so many as fill the grid's field of view; @param spacing_mm 0s:
/// such that `size` voxels fill it.
[[nodiscard]] Grid on_matrix(const Grid& grid, const Index3& size, const Vec3& spacing_mm);

/// @throws Error{InvalidInput} if a number is out of range, the grid's axes are not perpendicular,
/// or the heart leaves the field of view in any phase.
void check_spec(const PhantomSpec& spec);

/// {"name", "grid": {"size", "lps_from_index" (16, row-major)}, ..., "scanner": {..., "snr_blood":
/// number or null}, "anatomy"}.
[[nodiscard]] nlohmann::json spec_to_json(const PhantomSpec& spec);
/// Strict and checked; absent keys keep their default, but `grid` must be there.
/// @throws Error{InvalidInput} with the JSON path.
[[nodiscard]] PhantomSpec spec_from_json(const nlohmann::json& json);

/// - adult: axial, 15 phases of 256 x 256 x 64 voxels of 1 x 1 x 3 mm, 750 ms, SNR 20;
/// - small: the same heart, 10 phases of 88 x 88 x 44 voxels of 2 x 2 x 4 mm;
/// - clinical: 13 short-axis slices of 8 mm, 10 mm apart from below the apex to above the base,
///   pixels of 1.4 mm, 25 phases;
/// - infarct: adult with a thin, still segment in the LV's front wall;
/// - hard: adult with the low contrast of signals A, SNR 10, bias 50 %, slices shifted by 2 mm (one
///   standard deviation along rows and columns), the liver in touch with the heart.
/// @throws Error{Usage} listing the names if there is no such preset.
[[nodiscard]] PhantomSpec preset(const std::string& name);
[[nodiscard]] std::vector<std::string> preset_names();

}  // namespace beatlas::phantom
