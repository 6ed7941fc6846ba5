#include "pipeline/formats/dicom_objects.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include <vtkCallbackCommand.h>
#include <vtkCommand.h>
#include <vtkDICOMCompiler.h>
#include <vtkDICOMValue.h>
#include <vtkNew.h>

#include "runtime/base/error.h"
#include "runtime/base/sha256.h"

namespace beatlas::formats {
namespace {

constexpr const char* kExplicitLittleEndian = "1.2.840.10008.1.2.1";

}  // namespace

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

std::vector<std::uint16_t> words(std::span<const float> values) {
  std::vector<std::uint16_t> out(values.size());
  std::transform(values.begin(), values.end(), out.begin(), [](float value) {
    return static_cast<std::uint16_t>(static_cast<std::int32_t>(std::lround(value)));
  });
  return out;
}

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

void check_cine(const Cine& cine) {
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

std::string orientation_of(const Grid& grid) {
  const Vec3 spacing = grid.spacing_mm();
  const Vec3 row = grid.mm_from_index.linear().col(0) / spacing[0];
  const Vec3 column = grid.mm_from_index.linear().col(1) / spacing[1];
  return decimal_strings({row[0], row[1], row[2], column[0], column[1], column[2]});
}

std::string pixel_spacing_of(const Grid& grid) {
  const Vec3 spacing = grid.spacing_mm();
  return decimal_strings({spacing[1], spacing[0]});
}

std::string position_of(const Grid& grid, int slice) {
  const Vec3 position = grid.mm(0, 0, slice);
  return decimal_strings({position[0], position[1], position[2]});
}

void set_common(vtkDICOMMetaData& meta, const Cine& cine, const Range& range,
                const DicomWriteOptions& options, const std::string& content) {
  const Grid& grid = cine.grid();
  // Stands for the pixels, which the compiler appends.
  meta.Set(DC::PixelData, vtkDICOMValue(vtkDICOMVR::OW));
  meta.Set(DC::SpecificCharacterSet, "ISO_IR 192");
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
  meta.Set(DC::PatientPosition, "HFS");
  meta.Set(DC::StudyID, "1");
  meta.Set(DC::PositionReferenceIndicator, "");
  meta.Set(DC::SamplesPerPixel, 1);
  meta.Set(DC::PhotometricInterpretation, "MONOCHROME2");
  meta.Set(DC::Rows, grid.size[1]);
  meta.Set(DC::Columns, grid.size[0]);
  meta.Set(DC::BitsAllocated, 16);
  meta.Set(DC::BitsStored, 16);
  meta.Set(DC::HighBit, 15);
  meta.Set(DC::PixelRepresentation, range.low < 0 ? 1 : 0);
  const std::string& exam = options.exam.empty() ? content : options.exam;
  meta.Set(DC::StudyInstanceUID, uid_of("study " + exam));
  meta.Set(DC::FrameOfReferenceUID, uid_of("frame " + exam));
}

void write_object(const std::filesystem::path& file, vtkDICOMMetaData& meta, int frames,
                  const std::function<std::vector<std::uint16_t>(int)>& pixels) {
  vtkNew<vtkDICOMCompiler> compiler;
  vtkNew<vtkCallbackCommand> silent;  // errors come as a code; nothing may print
  silent->SetCallback([](vtkObject*, unsigned long, void*, void*) {});
  compiler->AddObserver(vtkCommand::ErrorEvent, silent);
  compiler->AddObserver(vtkCommand::WarningEvent, silent);
  compiler->SetFileName(file.c_str());
  compiler->SetTransferSyntaxUID(kExplicitLittleEndian);
  compiler->SetSOPInstanceUID(meta.Get(DC::SOPInstanceUID).AsString().c_str());
  compiler->SetSeriesInstanceUID(meta.Get(DC::SeriesInstanceUID).AsString().c_str());
  compiler->SetStudyInstanceUID(meta.Get(DC::StudyInstanceUID).AsString().c_str());
  compiler->SetMetaData(&meta);
  compiler->SetIndex(0);
  compiler->WriteHeader();
  for (int frame = 0; frame < frames && compiler->GetErrorCode() == 0; ++frame) {
    const std::vector<std::uint16_t> values = pixels(frame);
    compiler->WriteFrame(reinterpret_cast<const unsigned char*>(values.data()),
                         static_cast<vtkIdType>(std::span(values).size_bytes()));
  }
  compiler->Close();
  if (compiler->GetErrorCode() != 0) {
    throw Error(ErrorCode::Machine, file.string() + ": cannot be written");
  }
}

}  // namespace beatlas::formats
