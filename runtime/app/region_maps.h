#pragma once
/// Maps of an atlas's left ventricle that regions of disease name, from CSV.

#include <filesystem>

#include "runtime/palpation/regions.h"

namespace beatlas::app {

/// Every map that `regions` name, by that name.
/// - Painted: the columns `vertex` and `label` (whole numbers; vertices of lv_blood as `beatlas
/// export
///   --to obj` numbers them, from 0) or `segment` (1..17) and `label`; labels 0..255; what it does
///   not list has label 0.
/// - Measured: `kpa`, modulus of elasticity, with `vertex`, or with `x_mm`, `y_mm` and `z_mm`,
/// points of
///   the patient's frame (LPS) at end-diastole, each of which tells of the wall within the region's
///   reach.
/// @param folder that relative names start from
/// @throws Error{InvalidInput} naming file and line
[[nodiscard]] palpation::RegionMaps read_region_maps(const std::vector<palpation::Region>& regions,
                                                     const std::filesystem::path& folder,
                                                     const palpation::LvWall& wall,
                                                     const Affine& workspace_from_lps);

}  // namespace beatlas::app
