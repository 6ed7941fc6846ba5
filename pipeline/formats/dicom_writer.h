#pragma once
#include <filesystem>

#include "pipeline/core/exam.h"

namespace beatlas::formats {

struct DicomWriteOptions {
  bool series_per_slice = true;   ///< each slice its own series, as scanners often export cine
  double slice_thickness_mm = 0;  ///< SliceThickness; 0 = the distance of slices
  int first_series = 1;           ///< SeriesNumber of the first series
  /// What cines of one study and frame of reference have in common; empty: the cine stands alone.
  std::string exam = {};
  std::string description = "beatlas phantom";  ///< SeriesDescription; ASCII, at most 64 characters
  std::string comment = {};                     ///< ImageComments; ASCII; empty: none
};

/// Writes a cine as classic single-frame MR Image Storage objects (vtk-dicom, explicit little
/// endian), one file a slice and phase: FOLDER/slice_KKK/phase_PPP.dcm.
///
/// Position, orientation and spacing have the full 16 characters of a DS; the trigger time of
/// phase p of N is p/N of the R-R interval; NominalInterval is the R-R interval in whole ms. Pixel
/// values are rounded to 16 bit (signed only if one is negative). Names and dates are constants.
/// UIDs are 2.25.<number>, the number from the SHA-256 of the pixels and geometry, so that the same
/// cine gives the same bytes and another cine other UIDs.
///
/// @throws Error{Machine} if the folder cannot be written; Error{InvalidInput} if the cine is
/// empty,
///         has no R-R interval, axes that are not at right angles, or a value beyond 16 bit.
void write_dicom(const std::filesystem::path& folder, const Cine& cine,
                 const DicomWriteOptions& options = {});

/// Writes a cine as one Enhanced MR Image Storage object, FOLDER/cine.dcm: its frames run through
/// the phases of the first slice, then of the second.
///
/// What all frames share (spacing, orientation, kind) stands in the shared functional groups;
/// position, place in the stack, temporal position, trigger delay and R-R interval (in double) with
/// each frame. Else as write_dicom; `series_per_slice` has no meaning here.
void write_enhanced_dicom(const std::filesystem::path& folder, const Cine& cine,
                          const DicomWriteOptions& options = {});

}  // namespace beatlas::formats
