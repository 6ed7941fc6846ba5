#pragma once
/// 4-D NIfTI-1 in and out (niftilib). Our grids are LPS; the file's sform and qform are RAS; the
/// conversion happens here and nowhere else.

#include <filesystem>
#include <string>

#include "pipeline/core/grid.h"

namespace beatlas::formats {

struct NiftiHeader {
  double frame_interval_s = 0;  ///< pixdim[4] in seconds; 0 if the file has no time axis
  bool has_time_axis = false;   ///< more than one image along dimension 4 and its unit is time
  std::string note;             ///< what was odd and how it was resolved; empty if nothing was
};

/// Reads .nii or .nii.gz, any scalar type, applying scl_slope and scl_inter. One phase per image
/// along dimension 4. @throws Error{InvalidInput} naming the file and the reason.
[[nodiscard]] ImageCycle<float> read_nifti(const std::filesystem::path& file,
                                           NiftiHeader* header = nullptr);
/// The same for label images. @throws Error{InvalidInput} if a value is no whole number 0..255.
[[nodiscard]] ImageCycle<std::uint8_t> read_nifti_labels(const std::filesystem::path& file);

enum class NiftiStorage {
  Int16,
  UInt16Fraction,
  Float32
};  ///< UInt16Fraction: 0..1 in 65535 steps

/// Writes .nii or .nii.gz by its name; the same input gives the same bytes.
/// @param frame_interval_s seconds between phases (NIfTI assumes equal steps)
/// @throws Error{Machine} if the file cannot be written.
void write_nifti(const std::filesystem::path& file, const ImageCycle<float>& images,
                 double frame_interval_s, NiftiStorage storage);
void write_nifti_labels(const std::filesystem::path& file, const ImageCycle<std::uint8_t>& labels,
                        double frame_interval_s);

}  // namespace beatlas::formats
