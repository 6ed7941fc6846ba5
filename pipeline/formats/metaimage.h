#pragma once
/// MetaImage in: .mha and .mhd. A reader of our own: the metaio library takes a file that is cut
/// short for a whole one, prints to stderr and ends the program on a size it cannot hold.

#include "pipeline/formats/image_file.h"

namespace beatlas::formats {

/// Reads 3-D and 4-D images (the fourth axis holds the images one after another), plain, packed or
/// as text, of either byte order; data in the file, in one beside it, or in several.
///
/// Geometry: TransformMatrix (one axis of the grid a row), Offset and ElementSpacing in LPS.
/// Frames: ElementSpacing of the fourth axis; the format has no unit of time.
///
/// @throws Error{InvalidInput} naming the file and the reason
[[nodiscard]] ImageFile read_metaimage(const std::filesystem::path& file);

/// The files beside a header that hold its voxels, in their order; none where it holds them itself.
/// @throws Error{InvalidInput} without the file's name
[[nodiscard]] std::vector<std::filesystem::path> data_files_of_metaimage(
    const std::filesystem::path& file);

}  // namespace beatlas::formats
