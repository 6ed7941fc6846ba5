#pragma once
#include <cstdint>
#include <filesystem>

namespace beatlas::ingest {

/// How the data set of a file is written.
struct DicomEncoding {
  bool packed = false;       ///< pixels lie in fragments
  bool implicit = false;     ///< elements do not tell their kind
  bool big_endian = false;   ///< only of explicit, plain ones
  bool run_lengths = false;  ///< packed as RLE: a fragment is a frame
  int frames = 0;            ///< announced, of packed pixels; 0: not known
};

/// Whether a file goes on to the end of its last element: fragments of packed pixels are all there,
/// and what lies behind the pixels (private groups, signatures, padding) is not cut off. Where that
/// is written in a way not known here, the file counts as whole; so it does if only the mark behind
/// the fragments is missing, or if what lies behind the last element cannot be the start of another
/// (a newline, say).
/// @param pixels where the value of PixelData begins, in bytes
/// @param pixels_needed what plain pixels take at least, in bytes
[[nodiscard]] bool goes_on_to_its_end(const std::filesystem::path& file, std::int64_t pixels,
                                      double pixels_needed, const DicomEncoding& encoding);

/// The same of a file without pixels, from its first element.
[[nodiscard]] bool is_whole(const std::filesystem::path& file, const DicomEncoding& encoding);

/// Whether all of a file, from its preamble to its last byte, is elements as the standard writes
/// them, none longer than the file. Of a deflated file that is to be asked once it is inflated.
[[nodiscard]] bool is_understood(const std::filesystem::path& file);

}  // namespace beatlas::ingest
