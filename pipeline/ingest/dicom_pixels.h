#pragma once
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "pipeline/ingest/dicom_scan.h"

namespace beatlas::ingest {

/// What an image's pixels are worth.
enum class PixelState { Good, Damaged, NoNumber };

/// Reads images. Plain pixels come straight from the file, one frame at a time; packed ones
/// through a decoder, a whole file at a time (decoded_file.h).
class DicomPixels {
 public:
  DicomPixels();
  ~DicomPixels();
  DicomPixels(const DicomPixels&) = delete;
  DicomPixels& operator=(const DicomPixels&) = delete;

  /// Decodes or inflates the multi-frame file of this image and keeps it, in the width in which it
  /// is stored; does nothing for other images. Not for two threads at a time.
  /// @param most_bytes of all files kept; if this one does not fit, those before are let go
  void prepare(const DicomImage& image, double most_bytes);
  /// Lets all files go that are kept.
  void release();

  /// Fills `out` with rows x columns values in the units of the file's rescale, columns fastest,
  /// first row first; inverted images (MONOCHROME1) upright: stored value v counts as lowest +
  /// highest - v of what its bits can hold. Any number of threads at a time.
  [[nodiscard]] PixelState read(const DicomImage& image, std::span<float> out) const;

  /// The SHA-256 of an image's values; empty if they cannot be read. Keeps the multi-frame file of
  /// the image, alone. Not for two threads at a time.
  [[nodiscard]] std::string fingerprint(const DicomImage& image);

 private:
  struct Decoded;
  std::map<std::filesystem::path, std::unique_ptr<Decoded>> held_;
  double held_bytes_ = 0;
  mutable std::mutex decoder_;  ///< one at a time: each takes a whole file
};

}  // namespace beatlas::ingest
