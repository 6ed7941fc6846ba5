#pragma once
#include <filesystem>

#include "pipeline/core/exam.h"

namespace beatlas::formats {

struct DicomWriteOptions {
  bool series_per_slice = true;  ///< each slice its own series, as scanners often export cine
  std::string description = "beatlas phantom";
};

/// Writes a cine as classic single-frame MR Image Storage objects (vtk-dicom), with position,
/// orientation, trigger times and R-R. Pixel values are rounded to 16 bit. UIDs are derived from
/// the content, so the same cine gives the same bytes. @throws Error{Machine} if unwritable.
void write_dicom(const std::filesystem::path& folder, const Cine& cine,
                 const DicomWriteOptions& options = {});

}  // namespace beatlas::formats
