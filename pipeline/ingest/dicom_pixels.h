#pragma once
#include <vector>

#include "pipeline/ingest/dicom_scan.h"

namespace beatlas::ingest {

/// Reads images in the units of the file's rescale; keeps a multi-frame file open in memory.
class DicomPixels {
 public:
  /// rows x columns values, columns fastest, first row first.
  /// @throws Error{InvalidInput} naming a file that cannot be decoded.
  [[nodiscard]] std::vector<float> read(const DicomImage& image);

 private:
  std::filesystem::path file_;
  std::vector<std::vector<float>> frames_;  ///< stored values of file_, by frame
};

}  // namespace beatlas::ingest
