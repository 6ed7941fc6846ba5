#pragma once
/// What packed frames say of themselves, before a decoder is let at them.

#include <cstdint>
#include <filesystem>
#include <string_view>

namespace beatlas::ingest {

/// Whether a frame of JPEG, JPEG-LS or JPEG 2000 names a size within that of its image. A decoder
/// takes memory by what stands in the frame, whatever the header of the file says: a frame of 300
/// bytes can ask for 8 GB. What names no size is left to the decoder.
/// @param frame from its first byte on; what follows it does not matter
[[nodiscard]] bool frame_fits(std::string_view frame, int columns, int rows);

/// The same of all frames of a file. @param pixels where the value of PixelData begins, in bytes
/// @return false also if the file cannot be read
[[nodiscard]] bool packed_frames_fit(const std::filesystem::path& file, std::int64_t pixels,
                                     int columns, int rows);

}  // namespace beatlas::ingest
