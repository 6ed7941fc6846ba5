#pragma once
/// The headers of all images under some folders; no pixel is read here.

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/core/stage_context.h"
#include "pipeline/ingest/acquisition.h"
#include "pipeline/ingest/shown_path.h"
#include "pipeline/ingest/slice_timing.h"
#include "runtime/base/geometry.h"

namespace beatlas::ingest {

/// How the pixels of an image lie in its file.
struct PixelLayout {
  enum class Kind {
    Plain,    ///< whole numbers, one after another from `offset`
    Float,    ///< 32- or 64-bit IEEE numbers from `offset`
    Packed,   ///< a decoder is needed
    Unknown,  ///< no decoder is known that gets them right
  };
  Kind kind = Kind::Plain;
  std::int64_t offset = 0;  ///< of the first pixel of the frame, in the file as inflated
  int bits_allocated = 16;
  int bits_stored = 16;
  int high_bit = 15;
  bool is_signed = false;
  bool big_endian = false;
  bool deflated = false;  ///< all after the file's group 2 is
  bool inverted = false;  ///< MONOCHROME1: low values are bright
  int frames = 1;         ///< in the file
};

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
  PixelLayout layout;
  FrameStamp stamp;
  int series_number = 0;
  /// To tell series, patients and studies apart; never shown. Empty: the file does not say.
  std::string series_uid;
  std::string patient;  ///< ID and name, in one spelling
  std::string study_uid;
  std::string frame_of_reference_uid;
  Contrast contrast;  ///< images of a slice that differ in it are no phases of one cine
  Provenance provenance = Provenance::Original;
  std::string kind;  ///< ImageType or FrameType; never shown
  /// Of the phantom that it was made from: ImageComments, if they are a mark and nothing else.
  std::string phantom_identity;
  bool magnitude = true;  ///< false: a phase (velocity), real or imaginary image
};

struct DicomScan {
  std::vector<DicomImage> images;  ///< by series number, instance number, ...: never by file name
  int files = 0;                   ///< all that were looked at
  int not_dicom = 0;
  std::vector<std::filesystem::path> empty;  ///< files without a byte, in order
  int not_image = 0;                         ///< DICOMDIR, reports, presentation states
  int not_grey = 0;                          ///< colour
  int not_standard = 0;                      ///< of a transfer syntax that is not of the standard
  int without_place = 0;  ///< no position, orientation or pixel spacing (screenshots)
  int copies = 0;         ///< of an image already met
  int shared_uids = 0;    ///< images that differ from another of the same UID
  int straightened = 0;   ///< direction cosines that were not quite orthonormal
  int inverted = 0;       ///< images in which low values are bright
  /// Images by modality other than MR; "" stands for what is no code of the standard.
  std::map<std::string, int> other_modalities;
  IdentityWords words;  ///< of all headers that could be read, also in part
};

/// Reads the headers of `files`, in any order and on all threads; the result depends on neither.
/// @param sources what the user typed, for messages
/// @param named files the user named one by one: there, a file that is no DICOM is an error.
/// @throws Error{InvalidInput} that names the first file, by series and instance number, that is
///         truncated or damaged, or whose geometry is no geometry, and tells how many more are.
[[nodiscard]] DicomScan scan_dicom(const std::vector<std::filesystem::path>& sources,
                                   const std::vector<std::filesystem::path>& files, bool named,
                                   StageContext& context);

}  // namespace beatlas::ingest
