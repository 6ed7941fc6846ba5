#pragma once
/// NRRD in: .nrrd and .nhdr. A reader of our own: teem's keeps the whole series in its stored type
/// beside ours and tells errors through one buffer of the process, in words of the file.

#include "pipeline/formats/image_file.h"

namespace beatlas::formats {

/// Reads 3-D images and 4-D ones with the list or time axis anywhere (first in 3D Slicer's
/// sequences, .seq.nrrd); raw, ascii, gzip and bzip2; data in the file, in one beside it, or in
/// several (LIST, pattern).
///
/// Geometry: `space directions` and `space origin` in the file's `space` (LPS, RAS, LAS; with or
/// without time). A space that names no anatomy is taken as LPS, told in the note; so are
/// `spacings` without a space.
///
/// Frames: the axis without direction. Time by its unit and spacing, by `axis N index values`
/// (Slicer's sequences), or by `MultiVolume.FrameLabels` where those are trigger times. Kinds that
/// name colours, vectors and the like, and diffusion weighting, are no time.
///
/// @throws Error{InvalidInput} naming the file and the reason
[[nodiscard]] ImageFile read_nrrd(const std::filesystem::path& file);

/// The files beside a header that hold its voxels, in their order; none where it holds them itself.
/// @throws Error{InvalidInput} without the file's name
[[nodiscard]] std::vector<std::filesystem::path> data_files_of_nrrd(
    const std::filesystem::path& file);

}  // namespace beatlas::formats
