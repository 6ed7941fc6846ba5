#pragma once
/// The headers of all images under some folders; no pixel is read here.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/core/stage_context.h"
#include "pipeline/ingest/slice_timing.h"
#include "runtime/base/geometry.h"

namespace beatlas::ingest {

/// One grey image (a file, or one frame of a multi-frame file) that has a place in the patient.
struct DicomImage {
  std::filesystem::path file;
  int frame = 0;  ///< of the file, from 0
  int columns = 0;
  int rows = 0;
  Vec3 row_lps = Vec3::UnitX();      ///< unit; direction of growing column index
  Vec3 column_lps = Vec3::UnitY();   ///< unit, at a right angle to row_lps; of growing row index
  Vec3 position_lps = Vec3::Zero();  ///< centre of the first pixel [mm]
  double column_step_mm = 0;         ///< between columns, along row_lps
  double row_step_mm = 0;            ///< between rows, along column_lps
  double thickness_mm = 0;           ///< 0 if absent
  double rescale_slope = 1;
  double rescale_intercept = 0;
  FrameStamp stamp;
  int series_number = 0;
  std::string series_uid;  ///< to tell series apart; never shown
  /// Images of a slice with different contrast are no phases of one cine.
  double echo_ms = 0;
  double inversion_ms = 0;
  bool magnitude = true;  ///< false: a phase (velocity), real or imaginary image
};

struct DicomScan {
  std::vector<DicomImage> images;  ///< by series number, instance number, file name
  int files = 0;                   ///< all that were looked at
  int not_dicom = 0;
  int not_image = 0;      ///< DICOMDIR, reports, presentation states
  int not_grey = 0;       ///< colour or inverted
  int without_place = 0;  ///< no position, orientation or pixel spacing (screenshots)
  int copies = 0;         ///< of an image already met
  int straightened = 0;   ///< direction cosines that were not quite orthonormal
};

/// Reads the headers of `files`, in any order; the result does not depend on it.
/// @param named files the user named one by one: there, a file that is no DICOM is an error.
/// @throws Error{InvalidInput} naming a file that is truncated or damaged.
[[nodiscard]] DicomScan scan_dicom(const std::vector<std::filesystem::path>& files, bool named,
                                   StageContext& context);

}  // namespace beatlas::ingest
