#include "pipeline/formats/dicom_writer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <span>
#include <string>

#include <vtkDICOMMetaData.h>
#include <vtkDICOMValue.h>
#include <vtkNew.h>

#include "pipeline/formats/dicom_objects.h"
#include "runtime/base/error.h"

namespace beatlas::formats {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMrImageStorage = "1.2.840.10008.5.1.4.1.1.4";

/// What all images of a cine share beyond set_common.
void set_classic(vtkDICOMMetaData& meta, const Cine& cine, const Range& range,
                 const DicomWriteOptions& options) {
  const Grid& grid = cine.grid();
  const Vec3 spacing = grid.spacing_mm();
  const int phases = cine.phase_count();
  meta.Set(DC::ImageType, "ORIGINAL\\PRIMARY\\M");
  meta.Set(DC::SOPClassUID, kMrImageStorage);
  meta.Set(DC::ScanningSequence, "GR");
  meta.Set(DC::SequenceVariant, "NONE");
  meta.Set(DC::ScanOptions, "CG");
  meta.Set(DC::MRAcquisitionType, "2D");
  meta.Set(
      DC::SliceThickness,
      decimal_string(options.slice_thickness_mm > 0.0 ? options.slice_thickness_mm : spacing[2]));
  meta.Set(DC::RepetitionTime, decimal_string(cine.rr_interval_s * 1e3 / phases));
  meta.Set(DC::EchoTime, "");
  meta.Set(DC::SpacingBetweenSlices, decimal_string(spacing[2]));
  meta.Set(DC::EchoTrainLength, "1");
  meta.Set(DC::NominalInterval, std::to_string(std::lround(cine.rr_interval_s * 1e3)));
  meta.Set(DC::CardiacNumberOfImages, std::to_string(phases));
  meta.Set(DC::ImageOrientationPatient, orientation_of(grid));
  meta.Set(DC::NumberOfTemporalPositions, std::to_string(phases));
  meta.Set(DC::PixelSpacing, pixel_spacing_of(grid));
  meta.Set(DC::WindowCenter, decimal_string(0.5 * static_cast<double>(range.low + range.high)));
  meta.Set(DC::WindowWidth,
           decimal_string(std::max(1.0, static_cast<double>(range.high - range.low))));
}

std::string numbered(const char* format, int number) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), format, number);
  return text.data();
}

}  // namespace

void write_dicom(const fs::path& folder, const Cine& cine, const DicomWriteOptions& options) {
  check_cine(cine);
  const Range range = range_of(cine);
  const Grid& grid = cine.grid();
  const int slices = grid.size[2];
  const int phases = cine.phase_count();
  const std::string content = content_of(cine);

  vtkNew<vtkDICOMMetaData> meta;
  meta->SetNumberOfInstances(1);
  set_common(*meta, cine, range, options, content);
  set_classic(*meta, cine, range, options);

  for (int k = 0; k < slices; ++k) {
    const fs::path slice_folder = folder / numbered("slice_%03d", k + 1);
    std::error_code error;
    fs::create_directories(slice_folder, error);
    if (error) throw Error(ErrorCode::Machine, slice_folder.string() + ": cannot be made");

    const int series = options.series_per_slice ? k + 1 : 1;
    meta->Set(DC::SeriesInstanceUID, uid_of("series " + std::to_string(series) + ' ' + content));
    meta->Set(DC::SeriesNumber, std::to_string(options.first_series + series - 1));
    meta->Set(DC::ImagePositionPatient, position_of(grid, k));
    for (int p = 0; p < phases; ++p) {
      const int instance = (options.series_per_slice ? 0 : k * phases) + p + 1;
      meta->Set(DC::SOPInstanceUID,
                uid_of("image " + std::to_string(k) + ' ' + std::to_string(p) + ' ' + content));
      meta->Set(DC::InstanceNumber, std::to_string(instance));
      meta->Set(DC::TemporalPositionIdentifier, std::to_string(p + 1));
      meta->Set(DC::TriggerTime, decimal_string(cine.rr_interval_s * 1e3 * p / phases));
      write_object(slice_folder / numbered("phase_%03d.dcm", p + 1), *meta, 1, [&](int) {
        return words(std::span(cine.images.phases[static_cast<std::size_t>(p)])
                         .subspan(grid.offset(0, 0, k), grid.slice_count()));
      });
    }
  }
}

}  // namespace beatlas::formats
