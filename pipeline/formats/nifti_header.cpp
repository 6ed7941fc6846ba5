#include "pipeline/formats/nifti_header.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <string>

#include "pipeline/core/phantom_mark.h"
#include "runtime/base/error.h"

namespace beatlas::formats {
namespace {

constexpr std::size_t kBytes1 = 348;
constexpr std::size_t kBytes2 = 540;
constexpr std::size_t kDescription = 80;
constexpr const char* kNoNifti = "it is no NIfTI image, or its header is damaged";

/// Reads numbers at fixed places of the header.
class Fields {
 public:
  Fields(std::span<const std::byte> bytes, bool swapped) : bytes_(bytes), swapped_(swapped) {}

  template <class T>
  [[nodiscard]] T at(std::size_t offset) const {
    std::array<std::byte, sizeof(T)> raw{};
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset), sizeof(T), raw.begin());
    if (swapped_) std::reverse(raw.begin(), raw.end());
    return std::bit_cast<T>(raw);
  }
  /// Up to a null, of at most `most` characters.
  [[nodiscard]] std::string text(std::size_t offset, std::size_t most) const {
    const auto* first = reinterpret_cast<const char*>(bytes_.data() + offset);
    return {first, std::find(first, first + most, '\0')};
  }
  [[nodiscard]] bool says(std::size_t offset, std::string_view text) const {
    return std::memcmp(bytes_.data() + offset, text.data(), text.size()) == 0;
  }

 private:
  std::span<const std::byte> bytes_;
  bool swapped_;
};

ScalarType scalar_type(int code) {
  switch (code) {
    case 2:
      return ScalarType::UInt8;
    case 4:
      return ScalarType::Int16;
    case 8:
      return ScalarType::Int32;
    case 16:
      return ScalarType::Float32;
    case 64:
      return ScalarType::Float64;
    case 256:
      return ScalarType::Int8;
    case 512:
      return ScalarType::UInt16;
    case 768:
      return ScalarType::UInt32;
    case 1024:
      return ScalarType::Int64;
    case 1280:
      return ScalarType::UInt64;
    case 128:
    case 2304:
      throw_invalid("it is a colour image, grey values are needed");
    case 32:
    case 1792:
    case 2048:
      throw_invalid("its voxels are complex numbers; export the magnitude image");
    default:
      throw_invalid("its voxel type (NIfTI code " + std::to_string(code) +
                    ") is no real number that can be read");
  }
}

void set_sizes(const std::array<std::int64_t, 8>& dim, NiftiFields& out) {
  if (dim[0] < 1 || dim[0] > 7) throw_invalid(kNoNifti);
  for (std::int64_t d = 1; d <= dim[0]; ++d) {
    const std::int64_t size = dim[static_cast<std::size_t>(d)];
    if (size < 1 || size > std::int64_t{1} << 31) {
      throw_invalid("its header names an image without voxels");
    }
    if (d <= 4) {
      out.size[static_cast<std::size_t>(d - 1)] = size;
    } else if (size > 1) {
      throw_invalid("it has more than four dimensions (x, y, z and time are read)");
    }
  }
}

void set_offset(double offset, std::size_t header_bytes, NiftiFields& out) {
  if (!(offset >= 0 && offset < 1e12)) throw_invalid(kNoNifti);
  // 0 in a single file is what careless writers leave: the voxels follow the header and its mark.
  const auto least = out.pair ? 0.0 : static_cast<double>(header_bytes + 4);
  out.offset = static_cast<std::int64_t>(std::max(offset, least));
}

void set_scaling(double slope, double intercept, NiftiFields& out) {
  // 0 or no number: the standard's way to say that there is none.
  if (!std::isfinite(slope) || slope == 0) return;
  out.slope = slope;
  out.intercept = std::isfinite(intercept) ? intercept : 0;
}

NiftiFields parse_1(const Fields& f) {
  NiftiFields out;
  if (!f.says(344, {"n+1\0", 4}) && !f.says(344, {"ni1\0", 4})) {
    throw_invalid(
        "it is an Analyze 7.5 image or a damaged NIfTI file: it does not tell its orientation; "
        "convert it to NIfTI");
  }
  out.pair = f.says(344, "ni1");
  std::array<std::int64_t, 8> dim{};
  for (std::size_t d = 0; d < 8; ++d) {
    dim[d] = f.at<std::int16_t>(40 + 2 * d);
    out.pixdim[d] = f.at<float>(76 + 4 * d);
  }
  set_sizes(dim, out);
  out.type = scalar_type(f.at<std::int16_t>(70));
  set_offset(f.at<float>(108), kBytes1, out);
  set_scaling(f.at<float>(112), f.at<float>(116), out);
  out.units = f.at<std::uint8_t>(123);
  out.intent = f.at<std::int16_t>(68);
  out.qform_code = f.at<std::int16_t>(252);
  out.sform_code = f.at<std::int16_t>(254);
  for (std::size_t i = 0; i < 3; ++i) {
    out.quatern[i] = f.at<float>(256 + 4 * i);
    out.qoffset[i] = f.at<float>(268 + 4 * i);
  }
  for (std::size_t i = 0; i < 12; ++i) out.srow[i] = f.at<float>(280 + 4 * i);
  out.phantom_identity = identity_of_mark(f.text(148, kDescription));
  return out;
}

NiftiFields parse_2(const Fields& f) {
  NiftiFields out;
  if (!f.says(4, {"n+2\0", 4}) && !f.says(4, {"ni2\0", 4})) throw_invalid(kNoNifti);
  out.pair = f.says(4, "ni2");
  std::array<std::int64_t, 8> dim{};
  for (std::size_t d = 0; d < 8; ++d) {
    dim[d] = f.at<std::int64_t>(16 + 8 * d);
    out.pixdim[d] = f.at<double>(104 + 8 * d);
  }
  set_sizes(dim, out);
  out.type = scalar_type(f.at<std::int16_t>(12));
  set_offset(static_cast<double>(f.at<std::int64_t>(168)), kBytes2, out);
  set_scaling(f.at<double>(176), f.at<double>(184), out);
  out.units = f.at<std::int32_t>(500);
  out.intent = f.at<std::int32_t>(504);
  out.qform_code = f.at<std::int32_t>(344);
  out.sform_code = f.at<std::int32_t>(348);
  for (std::size_t i = 0; i < 3; ++i) {
    out.quatern[i] = f.at<double>(352 + 8 * i);
    out.qoffset[i] = f.at<double>(376 + 8 * i);
  }
  for (std::size_t i = 0; i < 12; ++i) out.srow[i] = f.at<double>(400 + 8 * i);
  out.phantom_identity = identity_of_mark(f.text(240, kDescription));
  return out;
}

/// Index -> RAS by the quaternion, as the NIfTI standard's method 2 has it.
Affine qform(const NiftiFields& fields) {
  double b = fields.quatern[0];
  double c = fields.quatern[1];
  double d = fields.quatern[2];
  const double squares = b * b + c * c + d * d;
  double a = 0;
  if (1 - squares < 1e-7) {  // a half turn; the standard's own tolerance
    const double norm = std::sqrt(squares);
    b /= norm;
    c /= norm;
    d /= norm;
  } else {
    a = std::sqrt(1 - squares);
  }
  Affine out = Affine::Identity();
  out.linear() = Eigen::Quaterniond(a, b, c, d).toRotationMatrix();
  const double handedness = fields.pixdim[0] < 0 ? -1 : 1;
  out.linear() *=
      Vec3(fields.pixdim[1], fields.pixdim[2], handedness * fields.pixdim[3]).asDiagonal();
  out.translation() = Vec3(fields.qoffset[0], fields.qoffset[1], fields.qoffset[2]);
  return out;
}

bool between(int value, int low, int high) { return value >= low && value <= high; }

/// What the intent of the file makes of its fourth axis; empty if it may be time.
std::string other_intent(int intent) {
  if (between(intent, 2, 24) || between(intent, 1001, 1001)) return "a list of statistics";
  if (between(intent, 1003, 1010)) return "the components of a vector or matrix";
  if (between(intent, 2003, 2005)) return "a colour or shape";
  if (between(intent, 2006, 2018)) return "a displacement";
  return {};
}

}  // namespace

NiftiFields parse_nifti_header(std::span<const std::byte> bytes) {
  if (bytes.size() < kBytes1) throw_invalid(kNoNifti);
  for (const bool swapped : {false, true}) {
    const Fields fields(bytes, swapped);
    const auto told = fields.at<std::int32_t>(0);
    if (told != kBytes1 && (told != kBytes2 || bytes.size() < kBytes2)) continue;
    NiftiFields out = told == kBytes1 ? parse_1(fields) : parse_2(fields);
    out.big_endian = swapped == (std::endian::native == std::endian::little);
    return out;
  }
  throw_invalid(kNoNifti);
}

NiftiGeometry geometry_of(const NiftiFields& fields) {
  double to_mm = 1;
  if ((fields.units & 7) == 1) to_mm = 1000;  // metres
  if ((fields.units & 7) == 3) to_mm = 1e-3;  // micrometres
  const auto scaled = [to_mm](Affine affine) {
    affine.matrix().topRows<3>() *= to_mm;
    return affine;
  };
  NiftiGeometry out;
  for (std::size_t d = 0; d < 3; ++d) out.pixdim_mm[d] = fields.pixdim[d + 1] * to_mm;
  out.has_sform = fields.sform_code > 0;
  out.has_qform = fields.qform_code > 0;
  out.qform_ras = scaled(qform(fields));
  Affine sform = Affine::Identity();
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 4; ++c) {
      sform.matrix()(r, c) = fields.srow[static_cast<std::size_t>(4 * r + c)];
    }
  }
  out.sform_ras = scaled(sform);
  return out;
}

ImageFileHeader frames_of(const NiftiFields& fields) {
  ImageFileHeader out;
  out.phantom_identity = fields.phantom_identity;
  if (fields.size[3] < 2) return out;
  out.frame_axis = FrameAxis::Untold;
  const double step = fields.pixdim[4];
  if (std::isfinite(step) && step > 0) out.frame_interval_s = step;
  double to_seconds = 0;
  switch (fields.units & 0x38) {
    case 8:
      to_seconds = 1;
      break;
    case 16:
      to_seconds = 1e-3;
      break;
    case 24:
      to_seconds = 1e-6;
      break;
    case 32:
      out.frame_axis_is = "a frequency (Hz)";
      break;
    case 40:
      out.frame_axis_is = "a chemical shift (ppm)";
      break;
    case 48:
      out.frame_axis_is = "an angle (rad/s)";
      break;
    default:
      break;
  }
  if (out.frame_axis_is.empty()) out.frame_axis_is = other_intent(fields.intent);
  if (!out.frame_axis_is.empty()) {
    out.frame_axis = FrameAxis::Other;
    out.frame_interval_s = 0;
  } else if (to_seconds > 0 && out.frame_interval_s > 0) {
    out.frame_axis = FrameAxis::Time;
    out.unit_known = true;
    out.frame_interval_s *= to_seconds;
  }
  return out;
}

}  // namespace beatlas::formats
