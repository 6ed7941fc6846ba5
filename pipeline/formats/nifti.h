#pragma once
/// 4-D NIfTI-1 in and out (niftilib). Our grids are LPS; the file's sform and qform are RAS; the
/// conversion happens in this room (nifti_geometry) and nowhere else.

#include <filesystem>
#include <string>

#include "pipeline/core/grid.h"

namespace beatlas::formats {

/// What a file says beside its voxels.
struct NiftiHeader {
  /// pixdim[4] in seconds by the unit the file names, or as it stands if it names none; 0 if there
  /// is one image only or pixdim[4] is no positive number. Not judged for plausibility here.
  double frame_interval_s = 0;
  bool has_time_axis = false;  ///< more than one image along dimension 4 and its unit is time
  std::string note;            ///< what was odd and how it was resolved; empty if nothing was
};

/// Reads .nii or .nii.gz, any real scalar type, applying scl_slope and scl_inter. One phase per
/// image along dimension 4; voxel order is the file's, the grid LPS of either handedness.
///
/// Geometry: the sform if its edge lengths agree with pixdim, else the qform (whose lengths are
/// pixdim by definition), else the sform's directions with the lengths of pixdim, or the sform as
/// it is where pixdim is the one that was left at 1 mm. Every such choice is told in the note.
///
/// @throws Error{InvalidInput} naming the file and the reason: not there, no NIfTI-1, truncated,
///         colour or complex, a value that is no number, more than four dimensions, no usable
///         voxel size, a sheared grid.
[[nodiscard]] ImageCycle<float> read_nifti(const std::filesystem::path& file,
                                           NiftiHeader* header = nullptr);
/// The same for label images. @throws Error{InvalidInput} if a value is no whole number 0..255.
[[nodiscard]] ImageCycle<std::uint8_t> read_nifti_labels(const std::filesystem::path& file,
                                                         NiftiHeader* header = nullptr);

enum class NiftiStorage {
  Int16,  ///< whole numbers as they are; else scaled if rounding would lose 1/1000 of range
  UInt16Fraction,  ///< 0..1 in 65535 steps
  Float32,
};

/// Writes .nii or .nii.gz by its name; the same input gives the same bytes (no time stamp).
/// sform and qform say the same (code 1, scanner).
/// @param frame_interval_s seconds between phases (NIfTI assumes equal steps); >= 0
/// @throws Error{Machine} if the file cannot be written; Error{InvalidInput} if the images do not
///         fill their grid, the file's name has another ending or a value is no number.
void write_nifti(const std::filesystem::path& file, const ImageCycle<float>& images,
                 double frame_interval_s, NiftiStorage storage);
void write_nifti_labels(const std::filesystem::path& file, const ImageCycle<std::uint8_t>& labels,
                        double frame_interval_s);

}  // namespace beatlas::formats
