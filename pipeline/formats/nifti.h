#pragma once
/// NIfTI in (versions 1 and 2, one file or .hdr beside .img) and out (version 1). Our grids are
/// LPS; the file's sform and qform are RAS; the conversion happens in this room (nifti_geometry)
/// and nowhere else.

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/formats/image_file.h"

namespace beatlas::formats {

/// Reads any real scalar type, applying scl_slope and scl_inter (a slope of 0 or no number: none).
/// One phase per image along dimension 4; voxel order is the file's, the grid LPS of either
/// handedness. Packed or not is seen from the bytes, not from the name.
///
/// Geometry: the sform if its edge lengths agree with pixdim, else the qform (whose lengths are
/// pixdim by definition), else the sform's directions with the lengths of pixdim, or the sform as
/// it is where pixdim is the one that was left at 1 mm. Every such choice is told in the note.
///
/// Frames: pixdim[4] by the unit in xyzt_units; Hz, ppm and rad/s, and intents that name vectors or
/// statistics, are no time.
///
/// @throws Error{InvalidInput} naming the file and the reason: not there, no NIfTI, Analyze 7.5,
///         truncated, damaged, colour or complex, a value that is no number, more than four
///         dimensions, no usable voxel size, a sheared grid.
[[nodiscard]] ImageCycle<float> read_nifti(const std::filesystem::path& file,
                                           ImageFileHeader* header = nullptr);
/// The same for label images. @throws Error{InvalidInput} if a value is no whole number 0..255.
[[nodiscard]] ImageCycle<std::uint8_t> read_nifti_labels(const std::filesystem::path& file,
                                                         ImageFileHeader* header = nullptr);

/// See files_of_image. @throws Error{InvalidInput} without the file's name
[[nodiscard]] std::vector<std::filesystem::path> files_of_nifti(const std::filesystem::path& file);

enum class NiftiStorage {
  Int16,  ///< whole numbers as they are; else scaled if rounding would lose 1/1000 of range
  UInt16Fraction,  ///< 0..1 in 65535 steps
  Float32,
};

/// Writes .nii or .nii.gz by its name; the same input gives the same bytes (no time stamp).
/// sform and qform say the same (code 1, scanner).
/// @param frame_interval_s seconds between phases (NIfTI assumes equal steps); >= 0
/// @param description descrip, ASCII, at most 79 characters
/// @throws Error{Machine} if the file cannot be written; Error{InvalidInput} if the images do not
///         fill their grid, the file's name has another ending or a value is no number.
void write_nifti(const std::filesystem::path& file, const ImageCycle<float>& images,
                 double frame_interval_s, NiftiStorage storage,
                 const std::string& description = "beatlas");
void write_nifti_labels(const std::filesystem::path& file, const ImageCycle<std::uint8_t>& labels,
                        double frame_interval_s);
/// The same of images that lie on another grid than their owner says. @param grid LPS
void write_nifti(const std::filesystem::path& file, const Grid& grid,
                 const std::vector<std::vector<float>>& phases, double frame_interval_s,
                 NiftiStorage storage, const std::string& description = "beatlas");
void write_nifti_labels(const std::filesystem::path& file, const Grid& grid,
                        const std::vector<std::vector<std::uint8_t>>& phases,
                        double frame_interval_s);

}  // namespace beatlas::formats
