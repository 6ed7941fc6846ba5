#include "pipeline/ingest/dicom_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <optional>

#include <vtkDICOMParser.h>
#include <vtkDICOMUtilities.h>
#include <vtkNew.h>
#include <vtkSmartPointer.h>

#include "pipeline/core/phantom_mark.h"
#include "pipeline/ingest/dicom_attributes.h"
#include "pipeline/ingest/dicom_end.h"
#include "pipeline/ingest/dicom_words.h"
#include "pipeline/ingest/inflated_file.h"
#include "pipeline/ingest/padded_file.h"
#include "pipeline/ingest/vtk_silence.h"
#include "runtime/base/plausible_size.h"

namespace beatlas::ingest {
namespace {

namespace fs = std::filesystem;

constexpr double kCosineTolerance = 0.02;    // about one degree; beyond it nothing can be trusted
constexpr double kStraightTolerance = 1e-4;  // six printed digits give 1e-6
constexpr double kFrameBytes = 3000;         // what is kept of a frame beside its pixels
constexpr double kMostFrames = 1e6;          // of one file; more are none that could be held
constexpr const char* kDeflated = ".1.99";
const std::string kStorage = "1.2.840.10008.5.1.4.1.1.";

/// Whether objects of a SOP class are images (PS3.4 B.5); not spectra, raw data, waveforms,
/// reports.
bool is_image_class(const std::string& uid) {
  if (uid.rfind(kStorage, 0) != 0) return false;
  const std::string rest = uid.substr(kStorage.size());
  const std::string family = rest.substr(0, rest.find('.'));
  // Computed radiography, CT, ultrasound, secondary capture, X-ray, NM, parametric map, visible
  // light, PET.
  for (const char* images : {"1", "2", "3", "6", "7", "12", "13", "20", "30", "77", "128", "130"}) {
    if (family == images) return true;
  }
  for (const char* images : {"4", "4.1", "4.3", "4.4", "66.4", "481.1", "481.2"}) {
    if (rest == images) return true;
  }
  return false;
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
  std::string component = attributes.text(DC::ComplexImageComponent);
  component.erase(component.find_last_not_of(' ') + 1);
  for (const char* other : {"PHASE", "REAL", "IMAGINARY"}) {
    if (component == other) return false;
  }
  for (const vtkDICOMTag tag : {vtkDICOMTag(DC::ImageType), vtkDICOMTag(DC::FrameType)}) {
    const vtkDICOMValue& value = attributes.get(tag);
    if (!value.IsValid()) continue;
    for (std::size_t i = 2; i < value.GetNumberOfValues(); ++i) {
      const std::string token = value.GetString(i);
      for (const char* other :
           {"P", "PHASE", "PHASE MAP", "VELOCITY", "R", "REAL", "I", "IMAGINARY"}) {
        if (token == other) return false;
      }
    }
  }
  return true;
}

std::string without_blanks(const std::string& text) {
  const auto first = text.find_first_not_of(' ');
  return first == std::string::npos ? std::string()
                                    : text.substr(first, text.find_last_not_of(' ') + 1 - first);
}

/// @param sop_class of the file
Provenance provenance_of(const Attributes& attributes, const std::string& sop_class) {
  const vtkDICOMValue& frame_type = attributes.get(DC::FrameType);
  const vtkDICOMValue& type = frame_type.IsValid() ? frame_type : attributes.get(DC::ImageType);
  const auto value = [&](std::size_t i) {
    const bool there = type.IsValid() && type.GetNumberOfValues() > i;
    return there ? without_blanks(type.GetString(i)) : std::string();
  };
  const bool capture = sop_class == kStorage + "7" || sop_class.rfind(kStorage + "7.", 0) == 0;
  if (capture || value(1) == "SECONDARY" ||
      without_blanks(attributes.text(DC::BurnedInAnnotation)) == "YES") {
    return Provenance::Secondary;
  }
  return value(0) == "DERIVED" ? Provenance::Derived : Provenance::Original;
}

/// The first letters of a SequenceName: digits and what follows them tell dimensions and segments.
std::string family_of(const std::string& name) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const auto first = std::find_if(name.begin(), name.end(), letter);
  return {first, std::find_if_not(first, name.end(), letter)};
}

Contrast contrast_of(const Attributes& attributes) {
  Contrast out;
  out.sequence =
      attributes.text(DC::ScanningSequence) + '\n' + attributes.text(DC::SequenceVariant);
  out.family = family_of(attributes.text(DC::SequenceName));
  if (out.family.empty()) out.family = family_of(attributes.text(DC::PulseSequenceName));
  out.echo_ms = attributes.first({DC::EchoTime, DC::EffectiveEchoTime}).value_or(0);
  out.inversion_ms = attributes.number(DC::InversionTime).value_or(0);
  out.flip_deg = attributes.number(DC::FlipAngle).value_or(0);
  return out;
}

FrameStamp stamp_of(const Attributes& attributes, int frame, int frames) {
  FrameStamp out;
  out.trigger_ms = attributes.first({DC::TriggerTime, DC::NominalCardiacTriggerDelayTime});
  out.rr_ms = attributes.first({DC::NominalInterval, DC::RRIntervalTimeNominal});
  if (!out.rr_ms || *out.rr_ms <= 0) {
    const auto rate = attributes.number(DC::HeartRate);
    if (rate && *rate > 0) out.rr_ms = 60000.0 / *rate;
  }
  out.frame_time_ms = attributes.number(DC::FrameTime);
  const vtkDICOMValue& steps = attributes.get(DC::FrameTimeVector);
  if (frames > 1 && steps.IsValid() &&
      steps.GetNumberOfValues() == static_cast<std::size_t>(frames)) {
    double elapsed = 0;
    for (int i = 1; i <= frame; ++i) {
      elapsed += attributes.number(DC::FrameTimeVector, static_cast<std::size_t>(i)).value_or(0);
    }
    out.elapsed_ms = elapsed;
  }
  out.temporal_position =
      attributes.first({DC::TemporalPositionIdentifier, DC::TemporalPositionIndex});
  out.acquisition_s = attributes.time_of_day_s(
      frames > 1 ? vtkDICOMTag(DC::FrameAcquisitionDateTime) : vtkDICOMTag(DC::AcquisitionTime));
  if (frames == 1) out.content_s = attributes.time_of_day_s(DC::ContentTime);
  out.acquisition_number = frames > 1 ? attributes.number(DC::FrameAcquisitionNumber)
                                      : attributes.number(DC::AcquisitionNumber);
  out.instance = attributes.number(DC::InstanceNumber);
  // Files of a phase each hold a frame of every slice: those of a slice go by the files' numbers.
  if (frames > 1) out.instance = out.instance.value_or(0) * kMostFrames + frame + 1;
  return out;
}

/// One spelling: upper case, no spaces or empty parts at the ends.
std::string one_spelling(const std::string& text) {
  std::string out;
  for (const char c : text) {
    const bool gap = c == ' ' || c == '^' || c == '=';
    if (gap && (out.empty() || out.back() == ' ')) continue;
    out += gap ? ' ' : c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
  }
  while (!out.empty() && out.back() == ' ') out.pop_back();
  return out;
}

std::string patient_of(vtkDICOMMetaData& meta) {
  const std::string id = one_spelling(meta.Get(0, DC::PatientID).AsUTF8String());
  const std::string name = one_spelling(meta.Get(0, DC::PatientName).AsUTF8String());
  return id.empty() && name.empty() ? std::string() : id + '\n' + name;
}

class FileReader {
 public:
  FileReader(const fs::path& file, IdentityWords& words) : file_(file), words_(words) {}

  FileHeader read() {
    std::error_code ignored;
    if (fs::file_size(file_, ignored) == 0 && !ignored) {
      out_.kind = Kind::Empty;
      return std::move(out_);
    }
    if (!is_dicom(file_)) return std::move(out_);
    out_.kind = sort_out();
    if (out_.kind == FileHeader::Kind::Image) add_frames();
    return std::move(out_);
  }

 private:
  using Kind = FileHeader::Kind;

  bool parse(const std::string& path) {
    meta_ = vtkSmartPointer<vtkDICOMMetaData>::New();
    vtkNew<vtkDICOMParser> parser;
    silence(parser);
    std::optional<PaddedFile> padded;
    if (!is_understood(path)) {
      padded.emplace(path);
      if (padded->path().empty()) return false;
    }
    parser->SetFileName(padded ? padded->path().c_str() : path.c_str());
    parser->SetMetaData(meta_);
    try {
      parser->Update();
    } catch (const std::bad_alloc&) {
      return false;  // it asks for the length that an element tells before it looks for the bytes
    }
    has_pixels_ = parser->GetPixelDataFound();
    offset_ = parser->GetFileOffset();
    std::error_code failed;
    const std::uintmax_t size = fs::file_size(path, failed);
    held_ = failed ? 0 : static_cast<std::int64_t>(size) - offset_;
    return parser->GetErrorCode() == 0;
  }

  Kind sort_out() {
    bool good = parse(file_.string());
    const std::string family = "1.2.840.10008.1.2";
    const std::string syntax = meta_->Get(0, DC::TransferSyntaxUID).AsString();
    syntax_ = syntax.rfind(family, 0) == 0 ? syntax.substr(family.size()) : std::string();
    if (syntax_ == kDeflated) {
      const InflatedFile inflated(file_);
      if (inflated.too_large()) return too_large("what it inflates to is more than");
      good = inflated.good() && parse(inflated.path());
    }
    add_words(*meta_, words_);
    out_.instance_uid = text(DC::SOPInstanceUID);
    out_.modality = text(DC::Modality);
    const Attributes whole(meta_, 0, 1);
    out_.series_number =
        static_cast<int>(std::clamp(whole.number(DC::SeriesNumber).value_or(0), -1e9, 1e9));
    out_.instance = whole.number(DC::InstanceNumber).value_or(0);
    const bool directory = text(DC::MediaStorageSOPClassUID) == "1.2.840.10008.1.3.10";
    if (directory) return Kind::NotImage;
    private_ = !syntax.empty() && syntax.rfind(family, 0) != 0;
    if (!good) return private_ ? Kind::Private : Kind::Damaged;
    if (private_ && (!meta_->Has(DC::Rows) || !has_pixels_)) return Kind::Private;
    if (!meta_->Has(DC::Rows) || !meta_->Has(DC::Columns)) {
      // A header cut off before its image looks like a report.
      const bool image = out_.modality == "MR" && mr_class();
      return image || cut_off(syntax) ? Kind::Damaged : Kind::NotImage;
    }
    if (!has_pixels_) {
      // Spectra and raw data have a matrix too.
      const bool image = text(DC::SOPClassUID).empty() || is_image_class(text(DC::SOPClassUID));
      return image || cut_off(syntax) ? Kind::Damaged : Kind::NotImage;
    }
    if (syntax_.rfind(".4.10", 0) == 0) return Kind::NotImage;  // video
    return find_layout();
  }

  /// Of a file that claims more than its bytes are believed to hold. @param claim "... more than"
  Kind too_large(const std::string& claim) {
    const std::uint64_t packed = file_bytes();
    out_.problem = claim + " the " + in_megabytes(plausible_bytes(packed, kImageUnpack)) +
                   " that a file of " + in_megabytes(packed) + " is believed to hold";
    return Kind::Wrong;
  }

  [[nodiscard]] std::uint64_t file_bytes() const {
    std::error_code failed;
    const std::uintmax_t size = fs::file_size(file_, failed);
    return failed ? 0 : size;
  }

  /// A file without pixels that ends within an element.
  [[nodiscard]] bool cut_off(const std::string& syntax) const {
    return syntax_ != kDeflated && !syntax.empty() &&
           !is_whole(file_, {.implicit = syntax_.empty(), .big_endian = syntax_ == ".2"});
  }

  Kind find_layout() {
    const auto whole = [this](vtkDICOMTag tag, int otherwise) {
      return meta_->Has(tag) ? meta_->Get(0, tag).AsInt() : otherwise;
    };
    columns_ = whole(DC::Columns, 0);
    rows_ = whole(DC::Rows, 0);
    layout_.frames = std::max(whole(DC::NumberOfFrames, 1), 1);
    layout_.offset = offset_;
    layout_.bits_allocated = whole(DC::BitsAllocated, 16);
    layout_.bits_stored = whole(DC::BitsStored, layout_.bits_allocated);
    layout_.high_bit = whole(DC::HighBit, layout_.bits_stored - 1);
    layout_.is_signed = whole(DC::PixelRepresentation, 0) == 1;
    layout_.big_endian = syntax_ == ".2";
    layout_.deflated = syntax_ == kDeflated;
    const bool real = meta_->Has(DC::FloatPixelData) || meta_->Has(DC::DoubleFloatPixelData);
    const bool plain =
        private_ || syntax_.empty() || syntax_ == ".1" || syntax_ == ".2" || layout_.deflated;
    if (real) layout_.bits_allocated = meta_->Has(DC::DoubleFloatPixelData) ? 64 : 32;
    if (!plain && syntax_ != ".5" && syntax_.rfind(".4.", 0) != 0) return Kind::Damaged;
    const int samples = std::max(1, whole(DC::SamplesPerPixel, 1));
    const double needed = static_cast<double>(rows_) * columns_ * samples * layout_.frames *
                          layout_.bits_allocated / 8;
    if (plain && !private_ && needed > static_cast<double>(held_)) return Kind::Damaged;
    if (layout_.bits_allocated < 1) return Kind::Damaged;
    // Memory goes to pixels as floats and to what is known of each frame. A few bytes may promise
    // any number of frames, and of pixels too unless these lie in the file as they are.
    const bool as_they_are = plain && !private_ && !layout_.deflated;
    const double pixels = static_cast<double>(rows_) * columns_ * layout_.frames;
    const double wanted =
        kFrameBytes * layout_.frames + (as_they_are ? 0 : std::max(needed, sizeof(float) * pixels));
    if (wanted > static_cast<double>(plausible_bytes(file_bytes(), kImageUnpack))) {
      return too_large("the images that its header promises take more than");
    }
    // What is deflated was found whole on inflating it; without a meta header it is not known how
    // elements are written.
    const DicomEncoding encoding{.packed = !plain,
                                 .implicit = syntax_.empty(),
                                 .big_endian = layout_.big_endian,
                                 .run_lengths = syntax_ == ".5",
                                 .frames = layout_.frames};
    // Mostly nothing follows the pixels: then the file need not be opened once more.
    const bool nothing_follows = plain && static_cast<double>(held_) - needed >= 0 &&
                                 static_cast<double>(held_) - needed < 2;
    if (meta_->Has(DC::TransferSyntaxUID) && !layout_.deflated && !private_ && !nothing_follows &&
        !goes_on_to_its_end(file_, offset_, needed, encoding)) {
      return Kind::Damaged;
    }
    const std::string kind = text(DC::PhotometricInterpretation);
    layout_.inverted = kind == "MONOCHROME1";
    if (samples > 1 || !(layout_.inverted || kind == "MONOCHROME2" || kind.empty())) {
      return Kind::NotGrey;
    }
    set_pixel_kind(plain, real);
    return Kind::Image;
  }

  /// @param plain the pixels lie in the file as they are  @param real as floating-point numbers
  void set_pixel_kind(bool plain, bool real) {
    const int bits = layout_.bits_allocated;
    const bool words = bits == 16 || bits == 32 || (bits == 8 && !layout_.big_endian);
    const bool fits = layout_.bits_stored >= 1 && layout_.high_bit < bits &&
                      layout_.high_bit + 1 >= layout_.bits_stored;
    if (private_) {
      layout_.kind = PixelLayout::Kind::Unknown;
    } else if (!plain && layout_.high_bit + 1 != layout_.bits_stored) {
      layout_.kind = PixelLayout::Kind::Unknown;  // the decoder cuts bits off
    } else if (real) {
      layout_.kind = PixelLayout::Kind::Float;
    } else if (!plain || !words || !fits) {
      layout_.kind = PixelLayout::Kind::Packed;
    }
  }

  void add_frames() {
    for (int frame = 0; frame < layout_.frames; ++frame) {
      add(frame);
      if (out_.kind == Kind::Wrong) return;
    }
  }

  /// Says why the geometry of an original MR image is none; what was made from images, and other
  /// images, may be anything and is left.
  void wrong(const Attributes& attributes, const char* why) {
    const std::string sop_class = text(DC::SOPClassUID);
    const bool mr = sop_class.empty() ? out_.modality == "MR" : mr_class();
    if (!mr || provenance_of(attributes, sop_class) != Provenance::Original) {
      ++out_.without_place;
      return;
    }
    out_.kind = Kind::Wrong;
    out_.problem = why;
  }

  void add(int frame) {
    const Attributes attributes(meta_, frame, layout_.frames);
    if (!attributes.has(DC::ImagePositionPatient) || !attributes.has(DC::ImageOrientationPatient) ||
        !attributes.has(DC::PixelSpacing)) {
      ++out_.without_place;
      return;
    }
    const auto position = attributes.vector(DC::ImagePositionPatient, 0);
    const auto row = attributes.vector(DC::ImageOrientationPatient, 0);
    const auto column = attributes.vector(DC::ImageOrientationPatient, 3);
    const double row_step = attributes.number(DC::PixelSpacing, 0).value_or(0);
    const double column_step = attributes.number(DC::PixelSpacing, 1).value_or(0);
    if (!(row_step > 0) || !(column_step > 0)) {
      return wrong(attributes, "its pixel spacing is zero, negative or no number");
    }
    if (!position) return wrong(attributes, "its position is no number");
    DicomImage image;
    bool straightened = false;
    image.row_lps = row.value_or(Vec3::Zero());
    image.column_lps = column.value_or(Vec3::Zero());
    if (!orthonormalise(image.row_lps, image.column_lps, straightened)) {
      return wrong(attributes, "its direction cosines are not of unit length and at right angles");
    }
    if (rows_ < 1 || columns_ < 1) return wrong(attributes, "it has no pixel");
    out_.straightened += straightened ? 1 : 0;
    image.file = file_;
    image.frame = frame;
    image.rows = rows_;
    image.columns = columns_;
    image.position_lps = *position;
    image.row_step_mm = row_step;
    image.column_step_mm = column_step;
    image.thickness_mm = attributes.number(DC::SliceThickness).value_or(0);
    image.rescale_slope = attributes.number(DC::RescaleSlope).value_or(1);
    if (image.rescale_slope == 0) image.rescale_slope = 1;
    image.rescale_intercept = attributes.number(DC::RescaleIntercept).value_or(0);
    image.layout = layout_;
    if (layout_.kind != PixelLayout::Kind::Packed) {  // its frames have no place of their own
      image.layout.offset +=
          static_cast<std::int64_t>(frame) * rows_ * columns_ * (layout_.bits_allocated / 8);
    }
    image.stamp = stamp_of(attributes, frame, layout_.frames);
    image.series_number = out_.series_number;
    image.series_uid = text(DC::SeriesInstanceUID);
    if (image.series_uid.empty()) image.series_uid = std::to_string(image.series_number);
    image.patient = patient_of(*meta_);
    image.study_uid = text(DC::StudyInstanceUID);
    image.frame_of_reference_uid = text(DC::FrameOfReferenceUID);
    image.contrast = contrast_of(attributes);
    image.provenance = provenance_of(attributes, text(DC::SOPClassUID));
    image.kind = attributes.text(DC::FrameType);
    if (image.kind.empty()) image.kind = attributes.text(DC::ImageType);
    image.phantom_identity = identity_of_mark(text(DC::ImageComments));
    image.magnitude = is_magnitude(attributes);
    out_.images.push_back(std::move(image));
  }

  [[nodiscard]] std::string text(vtkDICOMTag tag) const { return meta_->Get(0, tag).AsString(); }

  [[nodiscard]] bool mr_class() const {
    const std::string uid = text(DC::SOPClassUID);
    return uid == kStorage + "4" || uid == kStorage + "4.1" || uid == kStorage + "4.4";
  }

  fs::path file_;
  IdentityWords& words_;
  FileHeader out_;
  vtkSmartPointer<vtkDICOMMetaData> meta_;
  std::string syntax_;  ///< what follows the family of the standard's transfer syntaxes
  PixelLayout layout_;
  bool private_ = false;  ///< the transfer syntax
  bool has_pixels_ = false;
  std::int64_t offset_ = 0;
  std::int64_t held_ = 0;  ///< bytes from offset_ on
  int rows_ = 0;
  int columns_ = 0;
};

}  // namespace

bool is_dicom(const fs::path& file) { return vtkDICOMUtilities::IsDICOMFile(file.c_str()); }

FileHeader read_header(const fs::path& file, IdentityWords& words) {
  return FileReader(file, words).read();
}

bool is_modality_code(const std::string& text) {
  static constexpr std::array kCodes = {
      "ANN",        "AR",       "ASMT",       "AU",         "BDUS",   "BI",    "BMD",
      "CFM",        "CR",       "CT",         "CTPROTOCOL", "DMS",    "DG",    "DOC",
      "DX",         "ECG",      "EEG",        "EMG",        "EOG",    "EPS",   "ES",
      "FID",        "GM",       "HC",         "HD",         "IO",     "IOL",   "IVOCT",
      "IVUS",       "KER",      "KO",         "LEN",        "LS",     "M3D",   "MG",
      "MR",         "NM",       "OAM",        "OCT",        "OP",     "OPM",   "OPT",
      "OPTBSV",     "OPTENF",   "OPV",        "OSS",        "OT",     "PA",    "PLAN",
      "POS",        "PR",       "PT",         "PX",         "REG",    "RESP",  "RF",
      "RG",         "RTDOSE",   "RTIMAGE",    "RTINTENT",   "RTPLAN", "RTRAD", "RTRECORD",
      "RTSEGANN",   "RTSTRUCT", "RWV",        "SEG",        "SM",     "SMR",   "SR",
      "SRF",        "STAIN",    "TEXTUREMAP", "TG",         "US",     "VA",    "XA",
      "XAPROTOCOL", "XC"};
  return std::find(kCodes.begin(), kCodes.end(), text) != kCodes.end();
}

}  // namespace beatlas::ingest
