#include "pipeline/formats/dicom_writer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include <vtkCallbackCommand.h>
#include <vtkCommand.h>
#include <vtkDICOMCompiler.h>
#include <vtkDICOMMetaData.h>
#include <vtkDICOMValue.h>
#include <vtkNew.h>

#include "runtime/base/error.h"
#include "runtime/base/sha256.h"

namespace beatlas::formats {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMrImageStorage = "1.2.840.10008.5.1.4.1.1.4";
constexpr const char* kExplicitLittleEndian = "1.2.840.10008.1.2.1";

/// The most digits of `value` that fit a DICOM decimal string.
std::string decimal_string(double value) {
  constexpr int kMostCharacters = 16;
  std::array<char, 40> text{};
  for (int digits = 16; digits > 0; --digits) {
    const int length = std::snprintf(text.data(), text.size(), "%.*g", digits, value);
    if (length <= kMostCharacters) return std::string(text.data());
  }
  return "0";
}

std::string decimal_strings(std::initializer_list<double> values) {
  std::string out;
  for (const double value : values) {
    if (!out.empty()) out += '\\';
    out += decimal_string(value);
  }
  return out;
}

/// 2.25.<decimal of the first 128 bits of the SHA-256 of `text`> (DICOM PS3.5 B.2).
std::string uid_of(const std::string& text) {
  const std::string hex = sha256_hex(std::as_bytes(std::span(text))).substr(0, 32);
  std::string decimal = "0";  // most significant digit first
  for (const char c : hex) {
    int carry = c <= '9' ? c - '0' : c - 'a' + 10;
    for (std::size_t i = decimal.size(); i-- > 0;) {
      carry += (decimal[i] - '0') * 16;
      decimal[i] = static_cast<char>('0' + carry % 10);
      carry /= 10;
    }
    for (; carry > 0; carry /= 10)
      decimal.insert(decimal.begin(), static_cast<char>('0' + carry % 10));
  }
  return "2.25." + decimal;
}

/// One image's 16-bit words, the same for signed and unsigned.
std::vector<std::uint16_t> words(std::span<const float> values) {
  std::vector<std::uint16_t> out(values.size());
  std::transform(values.begin(), values.end(), out.begin(), [](float value) {
    return static_cast<std::uint16_t>(static_cast<std::int32_t>(std::lround(value)));
  });
  return out;
}

struct Range {
  long low = 0;
  long high = 0;
};

Range range_of(const Cine& cine) {
  Range out;
  for (const auto& phase : cine.images.phases) {
    for (const float value : phase) {
      if (!(std::abs(value) < 1e6F)) throw_invalid("a voxel is no number that DICOM can hold");
      out.low = std::min(out.low, std::lround(value));
      out.high = std::max(out.high, std::lround(value));
    }
  }
  if (out.low < -32768 || out.high > (out.low < 0 ? 32767 : 65535)) {
    throw_invalid("voxel values from " + std::to_string(out.low) + " to " +
                  std::to_string(out.high) + " do not fit 16 bit: scale them first");
  }
  return out;
}

void check(const Cine& cine) {
  const Grid& grid = cine.grid();
  if (grid.count() == 0 || cine.images.phases.empty()) throw_invalid("the cine holds no image");
  if (std::max(grid.size[0], grid.size[1]) > std::numeric_limits<std::uint16_t>::max()) {
    throw_invalid("the images are too large for DICOM");
  }
  for (const auto& phase : cine.images.phases) {
    if (phase.size() != grid.count()) throw_invalid("a phase does not fill the grid");
  }
  if (!(cine.rr_interval_s > 0)) throw_invalid("the cine has no R-R interval");
  const Eigen::Matrix3d u = grid.mm_from_index.linear().colwise().normalized();
  constexpr double kSquare = 1e-4;  // DICOM asks for orthogonal direction cosines
  if (!u.allFinite() || !(u.transpose() * u).isIdentity(kSquare)) {
    throw_invalid("the axes of the grid are not at right angles");
  }
}

/// What all files of a cine share.
void set_common(vtkDICOMMetaData& meta, const Cine& cine, const Range& range,
                const DicomWriteOptions& options) {
  const Grid& grid = cine.grid();
  const Vec3 spacing = grid.spacing_mm();
  const Vec3 row = grid.mm_from_index.linear().col(0) / spacing[0];
  const Vec3 column = grid.mm_from_index.linear().col(1) / spacing[1];
  const int phases = cine.phase_count();

  meta.Set(DC::SpecificCharacterSet, "ISO_IR 192");
  meta.Set(DC::ImageType, "ORIGINAL\\PRIMARY\\M");
  meta.Set(DC::SOPClassUID, kMrImageStorage);
  for (const auto date : {DC::StudyDate, DC::SeriesDate, DC::AcquisitionDate, DC::ContentDate}) {
    meta.Set(date, "20000101");
  }
  for (const auto time : {DC::StudyTime, DC::SeriesTime, DC::AcquisitionTime, DC::ContentTime}) {
    meta.Set(time, "000000");
  }
  meta.Set(DC::AccessionNumber, "");
  meta.Set(DC::Modality, "MR");
  meta.Set(DC::Manufacturer, "beatlas");
  meta.Set(DC::ReferringPhysicianName, "");
  meta.Set(DC::SeriesDescription, options.description);
  if (!options.comment.empty()) meta.Set(DC::ImageComments, options.comment);
  meta.Set(DC::PatientName, "BEATLAS^ANONYMOUS");
  meta.Set(DC::PatientID, "BEATLAS");
  meta.Set(DC::PatientBirthDate, "");
  meta.Set(DC::PatientSex, "");
  meta.Set(DC::PatientIdentityRemoved, "YES");
  meta.Set(DC::DeidentificationMethod, "Written without any patient attribute");
  meta.Set(DC::BodyPartExamined, "HEART");
  meta.Set(DC::ScanningSequence, "GR");
  meta.Set(DC::SequenceVariant, "NONE");
  meta.Set(DC::ScanOptions, "CG");
  meta.Set(DC::MRAcquisitionType, "2D");
  meta.Set(DC::SliceThickness, decimal_string(spacing[2]));
  meta.Set(DC::RepetitionTime, decimal_string(cine.rr_interval_s * 1e3 / phases));
  meta.Set(DC::EchoTime, "");
  meta.Set(DC::SpacingBetweenSlices, decimal_string(spacing[2]));
  meta.Set(DC::EchoTrainLength, "1");
  meta.Set(DC::NominalInterval, std::to_string(std::lround(cine.rr_interval_s * 1e3)));
  meta.Set(DC::CardiacNumberOfImages, std::to_string(phases));
  meta.Set(DC::PatientPosition, "HFS");
  meta.Set(DC::StudyID, "1");
  meta.Set(DC::ImageOrientationPatient,
           decimal_strings({row[0], row[1], row[2], column[0], column[1], column[2]}));
  meta.Set(DC::PositionReferenceIndicator, "");
  meta.Set(DC::NumberOfTemporalPositions, std::to_string(phases));
  meta.Set(DC::SamplesPerPixel, 1);
  meta.Set(DC::PhotometricInterpretation, "MONOCHROME2");
  meta.Set(DC::Rows, grid.size[1]);
  meta.Set(DC::Columns, grid.size[0]);
  meta.Set(DC::PixelSpacing, decimal_strings({spacing[1], spacing[0]}));
  meta.Set(DC::BitsAllocated, 16);
  meta.Set(DC::BitsStored, 16);
  meta.Set(DC::HighBit, 15);
  meta.Set(DC::PixelRepresentation, range.low < 0 ? 1 : 0);
  meta.Set(DC::WindowCenter, decimal_string(0.5 * static_cast<double>(range.low + range.high)));
  meta.Set(DC::WindowWidth,
           decimal_string(std::max(1.0, static_cast<double>(range.high - range.low))));
}

std::string numbered(const char* format, int number) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), format, number);
  return text.data();
}

/// Content of the cine as text: hashes of its images, its geometry and time.
std::string content_of(const Cine& cine) {
  std::string text;
  for (const auto& phase : cine.images.phases) {
    const auto pixel_words = words(phase);
    text += sha256_hex(std::as_bytes(std::span(pixel_words)));
  }
  const auto& matrix = cine.grid().mm_from_index.matrix();
  for (int i = 0; i < 12; ++i) text += ' ' + decimal_string(matrix(i % 3, i / 3));
  for (const int size : cine.grid().size) text += ' ' + std::to_string(size);
  return text + ' ' + decimal_string(cine.rr_interval_s);
}

void write_file(const fs::path& file, vtkDICOMMetaData& meta, const std::string& instance_uid,
                const std::string& series_uid, const std::string& study_uid,
                std::span<const std::uint16_t> pixels) {
  vtkNew<vtkDICOMCompiler> compiler;
  vtkNew<vtkCallbackCommand> silent;  // errors come as a code; nothing may print
  silent->SetCallback([](vtkObject*, unsigned long, void*, void*) {});
  compiler->AddObserver(vtkCommand::ErrorEvent, silent);
  compiler->AddObserver(vtkCommand::WarningEvent, silent);
  compiler->SetFileName(file.c_str());
  compiler->SetTransferSyntaxUID(kExplicitLittleEndian);
  compiler->SetSOPInstanceUID(instance_uid.c_str());
  compiler->SetSeriesInstanceUID(series_uid.c_str());
  compiler->SetStudyInstanceUID(study_uid.c_str());
  compiler->SetMetaData(&meta);
  compiler->SetIndex(0);
  compiler->WriteHeader();
  if (compiler->GetErrorCode() == 0) {
    compiler->WriteFrame(reinterpret_cast<const unsigned char*>(pixels.data()),
                         static_cast<vtkIdType>(pixels.size_bytes()));
  }
  compiler->Close();
  if (compiler->GetErrorCode() != 0) {
    throw Error(ErrorCode::Machine, file.string() + ": cannot be written");
  }
}

}  // namespace

void write_dicom(const fs::path& folder, const Cine& cine, const DicomWriteOptions& options) {
  check(cine);
  const Range range = range_of(cine);
  const Grid& grid = cine.grid();
  const int slices = grid.size[2];
  const int phases = cine.phase_count();
  const std::string content = content_of(cine);
  const std::string study_uid = uid_of("study " + content);

  vtkNew<vtkDICOMMetaData> meta;
  meta->SetNumberOfInstances(1);
  // Stands for the pixels, which the compiler appends.
  meta->Set(DC::PixelData, vtkDICOMValue(vtkDICOMVR::OW));
  set_common(*meta, cine, range, options);
  meta->Set(DC::StudyInstanceUID, study_uid);
  meta->Set(DC::FrameOfReferenceUID, uid_of("frame " + content));

  for (int k = 0; k < slices; ++k) {
    const fs::path slice_folder = folder / numbered("slice_%03d", k + 1);
    std::error_code error;
    fs::create_directories(slice_folder, error);
    if (error) throw Error(ErrorCode::Machine, slice_folder.string() + ": cannot be made");

    const int series = options.series_per_slice ? k + 1 : 1;
    const std::string series_uid = uid_of("series " + std::to_string(series) + ' ' + content);
    const Vec3 position = grid.mm(0, 0, k);
    meta->Set(DC::SeriesInstanceUID, series_uid);
    meta->Set(DC::SeriesNumber, std::to_string(series));
    meta->Set(DC::ImagePositionPatient, decimal_strings({position[0], position[1], position[2]}));
    for (int p = 0; p < phases; ++p) {
      const int instance = (options.series_per_slice ? 0 : k * phases) + p + 1;
      const std::string instance_uid =
          uid_of("image " + std::to_string(k) + ' ' + std::to_string(p) + ' ' + content);
      meta->Set(DC::SOPInstanceUID, instance_uid);
      meta->Set(DC::InstanceNumber, std::to_string(instance));
      meta->Set(DC::TemporalPositionIdentifier, std::to_string(p + 1));
      meta->Set(DC::TriggerTime, decimal_string(cine.rr_interval_s * 1e3 * p / phases));
      const auto pixels = words(std::span(cine.images.phases[static_cast<std::size_t>(p)])
                                    .subspan(grid.offset(0, 0, k), grid.slice_count()));
      write_file(slice_folder / numbered("phase_%03d.dcm", p + 1), *meta, instance_uid, series_uid,
                 study_uid, pixels);
    }
  }
}

}  // namespace beatlas::formats
