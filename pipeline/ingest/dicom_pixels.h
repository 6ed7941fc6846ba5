#pragma once
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
/// through a decoder, a whole file at a time.
class DicomPixels {
 public:
  DicomPixels();
  ~DicomPixels();
  DicomPixels(const DicomPixels&) = delete;
  DicomPixels& operator=(const DicomPixels&) = delete;

  /// Decodes the multi-frame file of this image and keeps it, in the width in which it is stored,
  /// until another file is prepared; does nothing for other images. Not for two threads at a time.
  void prepare(const DicomImage& image);

  /// Fills `out` with rows x columns values in the units of the file's rescale, columns fastest,
  /// first row first; inverted images (MONOCHROME1) upright: stored value v counts as lowest +
  /// highest - v of what its bits can hold. Any number of threads at a time.
  [[nodiscard]] PixelState read(const DicomImage& image, std::span<float> out) const;

  /// The SHA-256 of an image's values; empty if they cannot be read.
  [[nodiscard]] std::string fingerprint(const DicomImage& image) const;

 private:
  struct Decoded;
  std::unique_ptr<Decoded> held_;
  mutable std::mutex decoder_;  ///< VTK's pipelines are not made for several threads
};

}  // namespace beatlas::ingest
