#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "pipeline/ingest/dicom_scan.h"

namespace beatlas::ingest {

/// The pixels of a file of packed images, all frames, in the width in which they are stored.
/// Decoding takes place in a process of its own: the decoders are libraries that end their process
/// where a damaged file contradicts what they assume, print what they like, and may need long.
class DecodedFile {
 public:
  /// `good()` is false if the file cannot be decoded, or not within some minutes. Not for two
  /// threads at a time.
  explicit DecodedFile(const DicomImage& image);
  ~DecodedFile();
  DecodedFile(const DecodedFile&) = delete;
  DecodedFile& operator=(const DecodedFile&) = delete;

  [[nodiscard]] bool good() const { return good_; }
  /// Fills `out`, a frame's pixels as stored; false if there is no such frame.
  [[nodiscard]] bool read(int frame, std::span<float> out) const;

 private:
  void* shared_ = nullptr;  ///< memory that the two processes share
  std::size_t bytes_ = 0;
  std::size_t frames_ = 0;
  std::size_t frame_pixels_ = 0;
  bool good_ = false;
};

}  // namespace beatlas::ingest
