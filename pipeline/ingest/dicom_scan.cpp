#include "pipeline/ingest/dicom_scan.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include <vtkDICOMMetaData.h>
#include <vtkDICOMParser.h>
#include <vtkDICOMUtilities.h>
#include <vtkDICOMValue.h>
#include <vtkNew.h>

#include "pipeline/ingest/vtk_silence.h"
#include "runtime/base/error.h"

namespace beatlas::ingest {
namespace {

namespace fs = std::filesystem;

constexpr double kCosineTolerance = 0.02;    // about one degree; beyond it nothing can be trusted
constexpr double kStraightTolerance = 1e-4;  // six printed digits give 1e-6
constexpr int kMostFrames = 100000;

/// One frame's attributes, found wherever a classic or multi-frame object keeps them.
class Attributes {
 public:
  Attributes(vtkDICOMMetaData* meta, int frame, int frames)
      : meta_(meta), frame_(frame), frames_(frames) {}

  [[nodiscard]] const vtkDICOMValue& get(vtkDICOMTag tag) const {
    // A classic object may carry an empty per-frame sequence: only ask for frames if there are any.
    return frames_ > 1 ? meta_->Get(0, frame_, tag) : single(tag);
  }
  [[nodiscard]] std::optional<double> number(vtkDICOMTag tag, unsigned index = 0) const {
    const vtkDICOMValue& value = get(tag);
    if (!value.IsValid() || value.GetNumberOfValues() <= index) return std::nullopt;
    const double out = value.GetDouble(index);
    if (!std::isfinite(out)) return std::nullopt;
    return out;
  }
  [[nodiscard]] std::optional<double> first(std::initializer_list<vtkDICOMTag> tags) const {
    for (const vtkDICOMTag tag : tags) {
      if (const auto out = number(tag)) return out;
    }
    return std::nullopt;
  }
  [[nodiscard]] std::string text(vtkDICOMTag tag) const {
    const vtkDICOMValue& value = get(tag);
    return value.IsValid() ? value.AsString() : std::string();
  }

 private:
  [[nodiscard]] const vtkDICOMValue& single(vtkDICOMTag tag) const {
    const vtkDICOMValue& value = meta_->Get(0, tag);
    return value.IsValid() ? value : meta_->Get(0, 0, tag);
  }
  vtkDICOMMetaData* meta_;
  int frame_;
  int frames_;
};

std::optional<Vec3> vector(const Attributes& attributes, vtkDICOMTag tag, unsigned first) {
  Vec3 out;
  for (unsigned i = 0; i < 3; ++i) {
    const auto value = attributes.number(tag, first + i);
    if (!value) return std::nullopt;
    out[i] = *value;
  }
  return out;
}

/// The nearest pair of orthonormal vectors, both turned by the same angle.
bool orthonormalise(Vec3& row, Vec3& column, bool& straightened) {
  const double row_length = row.norm();
  const double column_length = column.norm();
  if (!(std::abs(row_length - 1) < kCosineTolerance) ||
      !(std::abs(column_length - 1) < kCosineTolerance) ||
      !(std::abs(row.dot(column)) < kCosineTolerance)) {
    return false;
  }
  straightened = std::abs(row_length - 1) > kStraightTolerance ||
                 std::abs(column_length - 1) > kStraightTolerance ||
                 std::abs(row.dot(column)) > kStraightTolerance;
  row /= row_length;
  column /= column_length;
  const Vec3 sum = (row + column).normalized();
  const Vec3 difference = (row - column).normalized();
  row = (sum + difference) * std::sqrt(0.5);
  column = (sum - difference) * std::sqrt(0.5);
  return true;
}

bool is_magnitude(const Attributes& attributes) {
  for (const vtkDICOMTag tag : {vtkDICOMTag(DC::ImageType), vtkDICOMTag(DC::FrameType)}) {
    const vtkDICOMValue& value = attributes.get(tag);
    if (!value.IsValid()) continue;
    for (unsigned i = 2; i < value.GetNumberOfValues(); ++i) {
      const std::string token = value.GetString(i);
      for (const char* other :
           {"P", "PHASE", "PHASE MAP", "VELOCITY", "R", "REAL", "I", "IMAGINARY"}) {
        if (token == other) return false;
      }
    }
  }
  return true;
}

FrameStamp stamp_of(const Attributes& attributes) {
  FrameStamp out;
  out.trigger_ms = attributes.first({DC::TriggerTime, DC::NominalCardiacTriggerDelayTime});
  out.rr_ms = attributes.first({DC::NominalInterval, DC::RRIntervalTimeNominal});
  if (!out.rr_ms || *out.rr_ms <= 0) {
    const auto rate = attributes.number(DC::HeartRate);
    if (rate && *rate > 0) out.rr_ms = 60000.0 / *rate;
  }
  out.frame_time_ms = attributes.number(DC::FrameTime);
  out.temporal_position =
      attributes.first({DC::TemporalPositionIdentifier, DC::TemporalPositionIndex});
  out.instance = attributes.number(DC::InstanceNumber);
  return out;
}

/// Reads files one after another and sorts out what is no image.
class Scanner {
 public:
  explicit Scanner(bool named) : named_(named) {}

  void file(const fs::path& path) {
    ++scan_.files;
    if (!vtkDICOMUtilities::IsDICOMFile(path.c_str())) {
      if (named_) throw_invalid(path.string() + ": it is no image that can be read");
      ++scan_.not_dicom;
      return;
    }
    vtkNew<vtkDICOMMetaData> meta;
    vtkNew<vtkDICOMParser> parser;
    silence(parser);
    parser->SetFileName(path.c_str());
    parser->SetMetaData(meta);
    parser->Update();
    if (parser->GetErrorCode() != 0) damaged(path);
    if (meta->Get(0, DC::MediaStorageSOPClassUID).AsString() == "1.2.840.10008.1.3.10" ||
        !meta->Has(DC::Rows) || !meta->Has(DC::Columns)) {
      // A header cut off before its image would look like a report: those never say MR or rows.
      if (meta->Get(0, DC::Modality).AsString() == "MR" && image_class(*meta)) damaged(path);
      ++scan_.not_image;
      return;
    }
    if (!parser->GetPixelDataFound()) damaged(path);
    if (is_video(*meta)) {
      ++scan_.not_image;
      return;
    }
    check_length(path, *parser, *meta);
    if (meta->Get(0, DC::SamplesPerPixel).AsInt() > 1 ||
        meta->Get(0, DC::PhotometricInterpretation).AsString() != "MONOCHROME2") {
      ++scan_.not_grey;
      return;
    }
    const std::string instance_uid = meta->Get(0, DC::SOPInstanceUID).AsString();
    if (!instance_uid.empty() && !met_.insert(instance_uid).second) {
      ++scan_.copies;
      return;
    }
    const int frames = std::clamp(frame_count(*meta), 1, kMostFrames);
    for (int frame = 0; frame < frames; ++frame) add(path, meta, frame, frames);
  }

  [[nodiscard]] DicomScan finish() {
    const auto key = [](const DicomImage& image) {
      return std::make_tuple(image.series_number, image.stamp.instance.value_or(0), image.frame);
    };
    std::sort(scan_.images.begin(), scan_.images.end(),
              [&](const DicomImage& a, const DicomImage& b) {
                const auto ka = key(a);
                const auto kb = key(b);
                if (ka != kb) return ka < kb;
                if (a.series_uid != b.series_uid) return a.series_uid < b.series_uid;
                return a.file < b.file;
              });
    return std::move(scan_);
  }

 private:
  [[noreturn]] static void damaged(const fs::path& path) {
    throw_invalid(path.string() +
                  ": the file is truncated or damaged; copy it again or take it out of the folder");
  }

  static int frame_count(vtkDICOMMetaData& meta) {
    const vtkDICOMValue& value = meta.Get(0, DC::NumberOfFrames);
    return value.IsValid() ? value.AsInt() : 1;
  }

  static bool image_class(vtkDICOMMetaData& meta) {
    const std::string uid = meta.Get(0, DC::SOPClassUID).AsString();
    return uid == "1.2.840.10008.5.1.4.1.1.4" || uid == "1.2.840.10008.5.1.4.1.1.4.1";
  }

  static bool is_video(vtkDICOMMetaData& meta) {
    return meta.Get(0, DC::TransferSyntaxUID).AsString().rfind("1.2.840.10008.1.2.4.10", 0) == 0;
  }

  static void check_length(const fs::path& path, vtkDICOMParser& parser, vtkDICOMMetaData& meta) {
    const std::string syntax = meta.Get(0, DC::TransferSyntaxUID).AsString();
    const std::string family = "1.2.840.10008.1.2";
    if (!syntax.empty() && syntax.rfind(family, 0) != 0) damaged(path);
    const std::string kind = syntax.empty() ? syntax : syntax.substr(family.size());
    const bool plain = kind.empty() || kind == ".1" || kind == ".2";
    const bool packed = kind == ".1.99" || kind == ".5" || kind.rfind(".4.", 0) == 0;
    if (!plain && !packed) damaged(path);
    if (packed) return;  // the decoder tells
    const double samples = std::max(1, meta.Get(0, DC::SamplesPerPixel).AsInt());
    const double needed =
        static_cast<double>(meta.Get(0, DC::Rows).AsInt()) * meta.Get(0, DC::Columns).AsInt() *
        samples * std::max(1, frame_count(meta)) * meta.Get(0, DC::BitsAllocated).AsInt() / 8;
    const auto held = static_cast<double>(parser.GetFileSize() - parser.GetFileOffset());
    if (needed > held) damaged(path);
  }

  void add(const fs::path& path, vtkDICOMMetaData* meta, int frame, int frames) {
    const Attributes attributes(meta, frame, frames);
    DicomImage image;
    const auto position = vector(attributes, DC::ImagePositionPatient, 0);
    const auto row = vector(attributes, DC::ImageOrientationPatient, 0);
    const auto column = vector(attributes, DC::ImageOrientationPatient, 3);
    const auto row_step = attributes.number(DC::PixelSpacing, 0);
    const auto column_step = attributes.number(DC::PixelSpacing, 1);
    bool straightened = false;
    if (row && column) {
      image.row_lps = *row;
      image.column_lps = *column;
    }
    image.rows = meta->Get(0, DC::Rows).AsInt();
    image.columns = meta->Get(0, DC::Columns).AsInt();
    if (!position || !row || !column || !row_step || !column_step || !(*row_step > 0) ||
        !(*column_step > 0) || image.rows < 1 || image.columns < 1 ||
        !orthonormalise(image.row_lps, image.column_lps, straightened)) {
      ++scan_.without_place;
      return;
    }
    scan_.straightened += straightened ? 1 : 0;
    image.file = path;
    image.frame = frame;
    image.position_lps = *position;
    image.row_step_mm = *row_step;
    image.column_step_mm = *column_step;
    image.thickness_mm = attributes.number(DC::SliceThickness).value_or(0);
    image.rescale_slope = attributes.number(DC::RescaleSlope).value_or(1);
    if (image.rescale_slope == 0) image.rescale_slope = 1;
    image.rescale_intercept = attributes.number(DC::RescaleIntercept).value_or(0);
    image.stamp = stamp_of(attributes);
    if (frames > 1) image.stamp.instance = frame + 1;
    image.series_number = static_cast<int>(attributes.number(DC::SeriesNumber).value_or(0));
    image.series_uid = attributes.text(DC::SeriesInstanceUID);
    image.echo_ms = attributes.first({DC::EchoTime, DC::EffectiveEchoTime}).value_or(0);
    image.inversion_ms = attributes.number(DC::InversionTime).value_or(0);
    image.magnitude = is_magnitude(attributes);
    scan_.images.push_back(std::move(image));
  }

  bool named_;
  DicomScan scan_;
  std::set<std::string> met_;
};

}  // namespace

DicomScan scan_dicom(const std::vector<fs::path>& files, bool named, StageContext& context) {
  std::vector<fs::path> sorted = files;  // which of two copies is kept must not depend on the order
  std::sort(sorted.begin(), sorted.end());
  Scanner scanner(named);
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    context.check_cancelled();
    scanner.file(sorted[i]);
    context.progress(0.4 * static_cast<double>(i + 1) / static_cast<double>(sorted.size()));
  }
  return scanner.finish();
}

}  // namespace beatlas::ingest
