#include <algorithm>
#include <cmath>
#include <span>
#include <string>

#include <vtkDICOMItem.h>
#include <vtkDICOMMetaData.h>
#include <vtkDICOMSequence.h>
#include <vtkDICOMValue.h>
#include <vtkNew.h>

#include "pipeline/formats/dicom_objects.h"
#include "pipeline/formats/dicom_writer.h"
#include "runtime/base/error.h"

namespace beatlas::formats {
namespace {

namespace fs = std::filesystem;

constexpr const char* kEnhancedMrStorage = "1.2.840.10008.5.1.4.1.1.4.1";
constexpr const char* kImageType = "ORIGINAL\\PRIMARY\\CARDIAC\\NONE";

vtkDICOMValue sequence(const vtkDICOMItem& item) {
  vtkDICOMSequence out;
  out.AddItem(item);
  return {out};
}

/// What the enhanced modules ask for of an image, a frame type and an object alike.
template <class Target>
void set_kind(Target& target) {
  target.Set(DC::PixelPresentation, "MONOCHROME");
  target.Set(DC::VolumetricProperties, "VOLUME");
  target.Set(DC::VolumeBasedCalculationTechnique, "NONE");
  target.Set(DC::ComplexImageComponent, "MAGNITUDE");
  target.Set(DC::AcquisitionContrast, "UNKNOWN");
}

vtkDICOMItem code(const char* value, const char* meaning) {
  vtkDICOMItem out;
  out.Set(DC::CodeValue, value);
  out.Set(DC::CodingSchemeDesignator, "SCT");
  out.Set(DC::CodeMeaning, meaning);
  return out;
}

vtkDICOMItem shared_groups(const Cine& cine, const Range& range, double thickness_mm) {
  const Grid& grid = cine.grid();
  vtkDICOMItem measures;
  measures.Set(DC::PixelSpacing, pixel_spacing_of(grid));
  measures.Set(DC::SliceThickness, decimal_string(thickness_mm));
  measures.Set(DC::SpacingBetweenSlices, decimal_string(grid.spacing_mm()[2]));
  vtkDICOMItem orientation;
  orientation.Set(DC::ImageOrientationPatient, orientation_of(grid));
  vtkDICOMItem kind;
  kind.Set(DC::FrameType, kImageType);
  set_kind(kind);
  vtkDICOMItem timing;
  timing.Set(DC::RepetitionTime, decimal_string(cine.rr_interval_s * 1e3 / cine.phase_count()));
  timing.Set(DC::EchoTrainLength, "1");
  vtkDICOMItem anatomy;
  anatomy.Set(DC::FrameLaterality, "U");
  anatomy.Set(DC::AnatomicRegionSequence, sequence(code("80891009", "Heart")));
  vtkDICOMItem value;
  value.Set(DC::RescaleIntercept, "0");
  value.Set(DC::RescaleSlope, "1");
  value.Set(DC::RescaleType, "US");
  vtkDICOMItem window;
  window.Set(DC::WindowCenter, decimal_string(0.5 * static_cast<double>(range.low + range.high)));
  window.Set(DC::WindowWidth,
             decimal_string(std::max(1.0, static_cast<double>(range.high - range.low))));
  vtkDICOMItem out;
  out.Set(DC::PixelMeasuresSequence, sequence(measures));
  out.Set(DC::PlaneOrientationSequence, sequence(orientation));
  out.Set(DC::MRImageFrameTypeSequence, sequence(kind));
  out.Set(DC::MRTimingAndRelatedParametersSequence, sequence(timing));
  out.Set(DC::FrameAnatomySequence, sequence(anatomy));
  out.Set(DC::PixelValueTransformationSequence, sequence(value));
  out.Set(DC::FrameVOILUTSequence, sequence(window));
  return out;
}

vtkDICOMItem frame_groups(const Cine& cine, int slice, int phase) {
  vtkDICOMItem content;
  content.Set(DC::FrameAcquisitionNumber, 1);
  content.Set(DC::StackID, "1");
  content.Set(DC::InStackPositionNumber, slice + 1);
  content.Set(DC::TemporalPositionIndex, phase + 1);
  const unsigned int index[] = {static_cast<unsigned int>(slice) + 1,
                                static_cast<unsigned int>(phase) + 1};
  content.Set(DC::DimensionIndexValues, vtkDICOMValue(vtkDICOMVR::UL, index, 2));
  vtkDICOMItem position;
  position.Set(DC::ImagePositionPatient, position_of(cine.grid(), slice));
  const double rr_ms = cine.rr_interval_s * 1e3;
  vtkDICOMItem beat;
  beat.Set(DC::NominalCardiacTriggerDelayTime, rr_ms * phase / cine.phase_count());
  beat.Set(DC::RRIntervalTimeNominal, rr_ms);
  vtkDICOMItem out;
  out.Set(DC::FrameContentSequence, sequence(content));
  out.Set(DC::PlanePositionSequence, sequence(position));
  out.Set(DC::CardiacSynchronizationSequence, sequence(beat));
  return out;
}

vtkDICOMItem dimension(const std::string& organization, vtkDICOMTag index, vtkDICOMTag group,
                       const char* label) {
  vtkDICOMItem out;
  out.Set(DC::DimensionOrganizationUID, organization);
  out.Set(DC::DimensionIndexPointer, vtkDICOMValue(vtkDICOMVR::AT, index));
  out.Set(DC::FunctionalGroupPointer, vtkDICOMValue(vtkDICOMVR::AT, group));
  out.Set(DC::DimensionDescriptionLabel, label);
  return out;
}

void set_enhanced(vtkDICOMMetaData& meta, const Cine& cine, const DicomWriteOptions& options,
                  const std::string& content) {
  meta.Set(DC::SOPClassUID, kEnhancedMrStorage);
  meta.Set(DC::SOPInstanceUID, uid_of("enhanced " + content));
  meta.Set(DC::SeriesInstanceUID, uid_of("series enhanced " + content));
  meta.Set(DC::SeriesNumber, std::to_string(options.first_series));
  meta.Set(DC::InstanceNumber, "1");
  meta.Set(DC::ManufacturerModelName, "beatlas");
  meta.Set(DC::DeviceSerialNumber, "0");
  meta.Set(DC::SoftwareVersions, "beatlas");
  meta.Set(DC::ImageType, kImageType);
  set_kind(meta);
  meta.Set(DC::AcquisitionNumber, "1");
  meta.Set(DC::AcquisitionDateTime, "20000101000000");
  meta.Set(DC::AcquisitionDuration, cine.rr_interval_s);
  meta.Set(DC::ContentQualification, "RESEARCH");
  meta.Set(DC::PresentationLUTShape, "IDENTITY");
  meta.Set(DC::LossyImageCompression, "00");
  meta.Set(DC::BurnedInAnnotation, "NO");
  meta.Set(DC::CardiacSynchronizationTechnique, "RETROSPECTIVE");
  meta.Set(DC::CardiacSignalSource, "ECG");
  meta.Set(DC::AcquisitionContextSequence, vtkDICOMValue(vtkDICOMSequence()));
  const std::string organization = uid_of("dimensions " + content);
  vtkDICOMItem dimensions;
  dimensions.Set(DC::DimensionOrganizationUID, organization);
  meta.Set(DC::DimensionOrganizationSequence, sequence(dimensions));
  vtkDICOMSequence indices;
  indices.AddItem(
      dimension(organization, DC::InStackPositionNumber, DC::FrameContentSequence, "Slice"));
  indices.AddItem(
      dimension(organization, DC::TemporalPositionIndex, DC::FrameContentSequence, "Phase"));
  meta.Set(DC::DimensionIndexSequence, vtkDICOMValue(indices));
}

}  // namespace

void write_enhanced_dicom(const fs::path& folder, const Cine& cine,
                          const DicomWriteOptions& options) {
  check_cine(cine);
  const Range range = range_of(cine);
  const Grid& grid = cine.grid();
  const int phases = cine.phase_count();
  const int frames = grid.size[2] * phases;
  const std::string content = content_of(cine);
  constexpr std::size_t kMostPixelBytes = 0xFFFFFFFE;
  if (grid.count() * static_cast<std::size_t>(phases) > kMostPixelBytes / 2) {
    throw_invalid("the cine is too large for one DICOM object");
  }

  vtkNew<vtkDICOMMetaData> meta;
  meta->SetNumberOfInstances(1);
  set_common(*meta, cine, range, options, content);
  set_enhanced(*meta, cine, options, content);
  meta->Set(DC::NumberOfFrames, std::to_string(frames));
  const double thickness_mm =
      options.slice_thickness_mm > 0.0 ? options.slice_thickness_mm : grid.spacing_mm()[2];
  meta->Set(DC::SharedFunctionalGroupsSequence, sequence(shared_groups(cine, range, thickness_mm)));
  vtkDICOMSequence each;
  for (int n = 0; n < frames; ++n) each.AddItem(frame_groups(cine, n / phases, n % phases));
  meta->Set(DC::PerFrameFunctionalGroupsSequence, vtkDICOMValue(each));

  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw Error(ErrorCode::Machine, folder.string() + ": cannot be made");
  write_object(folder / "cine.dcm", *meta, frames, [&](int n) {
    return words(std::span(cine.images.phases[static_cast<std::size_t>(n % phases)])
                     .subspan(grid.offset(0, 0, n / phases), grid.slice_count()));
  });
}

}  // namespace beatlas::formats
