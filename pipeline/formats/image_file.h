#pragma once
/// Images in files other than DICOM: NIfTI, NRRD, MetaImage. One value for what any of them gives.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/core/grid.h"

namespace beatlas::formats {

/// What a file says of the axis along which its images follow each other.
enum class FrameAxis {
  Absent,  ///< one image
  Time,    ///< the file says so
  Untold,  ///< images one after another; the file does not say what differs
  Other,   ///< the file says that it is no time
};

/// What a file says beside its voxels. Nothing is judged for plausibility here.
struct ImageFileHeader {
  FrameAxis frame_axis = FrameAxis::Absent;
  std::string frame_axis_is = {};  ///< for Other: what it is, to follow "its fourth axis is"
  /// Between images, in seconds by the unit the file names, or as the number stands if it names
  /// none (then unit_known is false); 0 if the file does not tell.
  double frame_interval_s = 0;
  /// When each image was taken, where the file tells each; else empty. Units as above.
  std::vector<double> frame_times_s = {};
  bool unit_known = false;
  std::string phantom_identity = {};  ///< from a mark (core/phantom_mark.h); no other text is kept
  std::string note = {};  ///< what was odd and how it was resolved, full sentences; mostly empty
};

struct ImageFile {
  ImageCycle<float> images;  ///< voxel order is the file's; the grid is LPS of either handedness
  ImageFileHeader header;
};

enum class ImageFormat { Nifti, Nrrd, MetaImage };

/// "nifti", "nrrd", "metaimage"
[[nodiscard]] std::string_view format_name(ImageFormat format) noexcept;

/// By the end of the name, upper or lower case: .nii .hdr .img (each also with .gz), .nrrd .nhdr,
/// .mha .mhd.
[[nodiscard]] std::optional<ImageFormat> format_of(const std::filesystem::path& file);

/// Whether a file of this name may hold the voxels of a header beside it and is no image itself:
/// .img .raw .zraw (each also with .gz or .bz2).
[[nodiscard]] bool may_be_voxels_of_another(const std::filesystem::path& file);

/// The files that an image is read from: the named one, or the header that belongs to it, then
/// those beside it that hold its voxels, in their order. Mostly the file alone.
/// @throws Error{InvalidInput} naming the file and the reason: its header cannot be read, or names
///         files that are not there
[[nodiscard]] std::vector<std::filesystem::path> files_of_image(const std::filesystem::path& file);

/// Reads a file of any of the formats; see nifti.h, nrrd.h, metaimage.h for what each holds.
/// Every voxel is finite. Needs memory for the voxels as float and little beside.
/// @throws Error{InvalidInput} naming the file and the reason
[[nodiscard]] ImageFile read_image_file(const std::filesystem::path& file);

}  // namespace beatlas::formats
