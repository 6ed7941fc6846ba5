#pragma once
/// Where a NIfTI file says its voxels are, and the same of ours: RAS <-> LPS.

#include <array>
#include <string>

#include "runtime/base/geometry.h"

namespace beatlas::formats {

/// The orientation fields of a NIfTI-1 header.
struct NiftiGeometry {
  std::array<double, 3> pixdim_mm{0, 0, 0};
  bool has_sform = false;
  bool has_qform = false;
  Affine sform_ras = Affine::Identity();  ///< index -> RAS [mm]
  Affine qform_ras = Affine::Identity();  ///< index -> RAS [mm]; its edge lengths are pixdim
};

/// Index -> LPS [mm]. Contradictions are resolved as nifti.h tells and added to `note`.
/// @throws Error{InvalidInput} without a usable voxel size or with sheared axes.
[[nodiscard]] Affine lps_from_index(const NiftiGeometry& geometry, std::string& note);

/// LPS -> RAS and back: x and y change sign.
[[nodiscard]] Affine flip_lps_ras(const Affine& mm_from_index);

}  // namespace beatlas::formats
