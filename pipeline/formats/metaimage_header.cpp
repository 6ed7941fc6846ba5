#include "pipeline/formats/metaimage_header.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "pipeline/formats/grid_axes.h"
#include "pipeline/formats/header_text.h"
#include "runtime/base/error.h"

namespace beatlas::formats {
namespace {

constexpr double kUnitLength = 1e-3;  // rows of a direction matrix printed with four digits

ScalarType element_type(const std::string& name) {
  static const std::map<std::string, ScalarType> types{
      {"met_char", ScalarType::Int8},       {"met_uchar", ScalarType::UInt8},
      {"met_short", ScalarType::Int16},     {"met_ushort", ScalarType::UInt16},
      {"met_int", ScalarType::Int32},       {"met_uint", ScalarType::UInt32},
      {"met_long", ScalarType::Int32},      {"met_ulong", ScalarType::UInt32},
      {"met_long_long", ScalarType::Int64}, {"met_ulong_long", ScalarType::UInt64},
      {"met_float", ScalarType::Float32},   {"met_double", ScalarType::Float64},
  };
  const auto found = types.find(name);
  if (found == types.end()) throw_invalid("its ElementType is none that can be read");
  return found->second;
}

/// The fields by name, up to and with ElementDataFile.
std::map<std::string, std::string_view> fields_of(std::string_view text, std::size_t& bytes) {
  std::map<std::string, std::string_view> out;
  std::string_view rest = text;
  while (!rest.empty() && out.count("elementdatafile") == 0) {
    const std::string_view line = take_line(rest);
    if (trimmed(line).empty()) continue;
    const std::size_t sign = line.find_first_of("=:");
    if (sign == std::string_view::npos) break;
    out[lower(trimmed(line.substr(0, sign)))] = trimmed(line.substr(sign + 1));
  }
  bytes = text.size() - rest.size();
  return out;
}

class Reader {
 public:
  explicit Reader(std::map<std::string, std::string_view> fields) : fields_(std::move(fields)) {}

  [[nodiscard]] bool has(const std::string& name) const { return fields_.count(name) != 0; }
  /// The value of the first of some names for the same; empty without any.
  [[nodiscard]] std::string_view text(std::initializer_list<const char*> names) const {
    for (const char* name : names) {
      const auto found = fields_.find(name);
      if (found != fields_.end()) return found->second;
    }
    return {};
  }
  [[nodiscard]] bool yes(std::initializer_list<const char*> names, bool otherwise) const {
    const std::string value = lower(text(names));
    if (value.empty()) return otherwise;
    return value.front() == 't' || value.front() == '1' || value.front() == 'y';
  }
  /// `count` numbers, or none.
  [[nodiscard]] std::vector<double> list(std::initializer_list<const char*> names,
                                         std::size_t count) const {
    const std::string name = *names.begin();
    std::vector<double> out = numbers(text(names), name);
    if (!out.empty() && out.size() != count) {
      throw_invalid("its header field \"" + name + "\" holds " + std::to_string(out.size()) +
                    " numbers where there should be " + std::to_string(count));
    }
    return out;
  }
  [[nodiscard]] double one(const char* name, double otherwise) const {
    const auto out = list({name}, 1);
    if (out.empty()) return otherwise;
    if (!std::isfinite(out[0]))
      throw_invalid(std::string("its header field \"") + name + "\" is no number");
    return out[0];
  }

 private:
  std::map<std::string, std::string_view> fields_;
};

double unit_mm(const std::string& unit) {
  if (unit == "m") return 1000;
  if (unit == "cm") return 10;
  if (unit == "um") return 1e-3;
  return 1;
}

}  // namespace

MetaFields parse_meta_header(std::string_view text) {
  MetaFields out;
  const Reader fields(fields_of(text, out.bytes));
  if (!fields.has("ndims") || !fields.has("elementdatafile") ||
      lower(fields.text({"objecttype"})).find("image") == std::string::npos) {
    throw_invalid("it is no MetaImage file, or its header is damaged");
  }
  const std::int64_t dimension = whole(fields.text({"ndims"}), "NDims", 1, 100);
  if (dimension > 4) throw_invalid("it has more than four dimensions (x, y, z and time are read)");
  if (dimension < 3) throw_invalid("it has fewer than three dimensions");
  const auto count = static_cast<std::size_t>(dimension);
  for (const std::string_view word : words(fields.text({"dimsize"}))) {
    out.size.push_back(whole(word, "DimSize", 1, std::int64_t{1} << 31));
  }
  if (out.size.size() != count)
    throw_invalid("its header field \"DimSize\" is not one size an axis");
  if (fields.has("elementnumberofchannels") &&
      whole(fields.text({"elementnumberofchannels"}), "ElementNumberOfChannels", 1, 1000) > 1) {
    throw_invalid("it holds several values a voxel (colour or vectors), grey values are needed");
  }
  out.type = element_type(lower(fields.text({"elementtype"})));
  out.spacing = fields.list({"elementspacing", "elementsize"}, count);
  if (out.spacing.empty()) throw_invalid("its header names no voxel size (ElementSpacing)");
  out.direction = fields.list({"transformmatrix", "rotation", "orientation"}, count * count);
  out.origin = fields.list({"offset", "position", "origin"}, count);
  out.to_mm = unit_mm(lower(fields.text({"distanceunits"})));
  out.big_endian = fields.yes({"binarydatabyteordermsb", "elementbyteordermsb"}, false);
  if (!fields.yes({"binarydata"}, true)) out.packing = Packing::Text;
  if (fields.yes({"compresseddata"}, false)) out.packing = Packing::Deflate;
  out.slope = fields.one("elementtointensityfunctionslope", 1);
  out.intercept = fields.one("elementtointensityfunctionoffset", 0);
  if (out.slope == 0) throw_invalid("its ElementToIntensityFunctionSlope is 0");
  if (fields.has("headersize")) {
    out.header_size = whole(fields.text({"headersize"}), "HeaderSize", -1, kMostBytes);
  }
  out.data_file = std::string(fields.text({"elementdatafile"}));
  return out;
}

Affine lps_from_index(const MetaFields& fields, std::string& note) {
  const std::size_t count = fields.size.size();
  if (!std::all_of(fields.spacing.begin(), fields.spacing.begin() + 3,
                   [](double edge) { return edge > 0 && std::isfinite(edge); })) {
    throw_invalid("its voxel size (ElementSpacing) is zero, negative or no number; correct it");
  }
  Affine out = Affine::Identity();
  if (fields.direction.empty()) {
    add_sentence(
        note, "The file holds no orientation, its axes were taken as left, posterior, superior.");
  } else {
    for (std::size_t axis = 0; axis < count; ++axis) {
      for (std::size_t r = 0; r < count; ++r) {
        const double value = fields.direction[axis * count + r];
        if (axis < 3 && r < 3) {
          out.linear()(static_cast<int>(r), static_cast<int>(axis)) = value;
        } else if (axis != r && value != 0) {
          throw_invalid("an axis of its grid runs through space and time at once");
        }
      }
    }
  }
  const Vec3 lengths = out.linear().colwise().norm().transpose();
  if (!usable_edges(lengths)) throw_invalid("its TransformMatrix is none; correct its header");
  if ((lengths.array() - 1).abs().maxCoeff() > kUnitLength) {
    add_sentence(note,
                 "The rows of TransformMatrix are not of length 1; the voxel sizes are those of "
                 "ElementSpacing.");
  }
  for (int axis = 0; axis < 3; ++axis) {
    out.linear().col(axis) *= fields.spacing[static_cast<std::size_t>(axis)] / lengths[axis];
  }
  if (!fields.origin.empty()) {
    out.translation() = Vec3(fields.origin[0], fields.origin[1], fields.origin[2]);
  }
  out.matrix().topRows<3>() *= fields.to_mm;
  return checked_axes(out, note);
}

ImageFileHeader frames_of(const MetaFields& fields) {
  ImageFileHeader out;
  if (fields.size.size() < 4 || fields.size[3] < 2) return out;
  out.frame_axis = FrameAxis::Untold;
  const double step = fields.spacing[3];
  if (std::isfinite(step) && step > 0) out.frame_interval_s = step;
  return out;
}

}  // namespace beatlas::formats
