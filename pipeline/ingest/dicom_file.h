#pragma once
/// The header of one DICOM file.

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/ingest/dicom_scan.h"

namespace beatlas::ingest {

struct FileHeader {
  enum class Kind {
    NotDicom,
    Empty,     ///< without a byte
    NotImage,  ///< DICOMDIR, reports, videos
    NotGrey,
    Image,    ///< also if none of its frames has a place
    Private,  ///< of a transfer syntax that is not of the standard, and cannot be looked into
    Damaged,
    Wrong,  ///< an MR image whose geometry is no geometry; `problem` says what
  };
  Kind kind = Kind::NotDicom;
  std::string problem;  ///< a clause without a full stop
  std::string instance_uid;
  std::string modality;  ///< as the file says; never shown unless it is a code of the standard
  int series_number = 0;
  double instance = 0;
  int without_place = 0;  ///< frames
  int straightened = 0;   ///< frames
  std::vector<DicomImage> images;
};

/// Whether a file is DICOM by its first bytes, with or without a preamble; one that is not is of
/// the kind NotDicom or Empty.
[[nodiscard]] bool is_dicom(const std::filesystem::path& file);

/// Reads one file; what its text attributes say goes into `words`. Never throws for bad input.
[[nodiscard]] FileHeader read_header(const std::filesystem::path& file, IdentityWords& words);

/// Whether a text is one of the modality codes of the standard (PS3.3 C.7.3.1.1.1).
[[nodiscard]] bool is_modality_code(const std::string& text);

}  // namespace beatlas::ingest
