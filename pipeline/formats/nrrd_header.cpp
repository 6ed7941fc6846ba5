#include "pipeline/formats/nrrd_header.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

#include "pipeline/formats/header_text.h"
#include "runtime/base/error.h"

namespace beatlas::formats {
namespace {

constexpr std::size_t kMostAxes = 16;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

ScalarType voxel_type(const std::string& name) {
  static const std::map<std::string, ScalarType> kTypes{
      {"signed char", ScalarType::Int8},
      {"int8", ScalarType::Int8},
      {"int8_t", ScalarType::Int8},
      {"uchar", ScalarType::UInt8},
      {"unsigned char", ScalarType::UInt8},
      {"uint8", ScalarType::UInt8},
      {"uint8_t", ScalarType::UInt8},
      {"short", ScalarType::Int16},
      {"short int", ScalarType::Int16},
      {"signed short", ScalarType::Int16},
      {"signed short int", ScalarType::Int16},
      {"int16", ScalarType::Int16},
      {"int16_t", ScalarType::Int16},
      {"ushort", ScalarType::UInt16},
      {"unsigned short", ScalarType::UInt16},
      {"unsigned short int", ScalarType::UInt16},
      {"uint16", ScalarType::UInt16},
      {"uint16_t", ScalarType::UInt16},
      {"int", ScalarType::Int32},
      {"signed int", ScalarType::Int32},
      {"int32", ScalarType::Int32},
      {"int32_t", ScalarType::Int32},
      {"uint", ScalarType::UInt32},
      {"unsigned int", ScalarType::UInt32},
      {"uint32", ScalarType::UInt32},
      {"uint32_t", ScalarType::UInt32},
      {"longlong", ScalarType::Int64},
      {"long long", ScalarType::Int64},
      {"long long int", ScalarType::Int64},
      {"signed long long", ScalarType::Int64},
      {"signed long long int", ScalarType::Int64},
      {"int64", ScalarType::Int64},
      {"int64_t", ScalarType::Int64},
      {"ulonglong", ScalarType::UInt64},
      {"unsigned long long", ScalarType::UInt64},
      {"unsigned long long int", ScalarType::UInt64},
      {"uint64", ScalarType::UInt64},
      {"uint64_t", ScalarType::UInt64},
      {"float", ScalarType::Float32},
      {"double", ScalarType::Float64},
  };
  const auto found = kTypes.find(name);
  if (found == kTypes.end()) throw_invalid("its voxel type is none that can be read");
  return found->second;
}

Packing packing(const std::string& name) {
  if (name == "raw") return Packing::Raw;
  if (name == "gz" || name == "gzip") return Packing::Deflate;
  if (name == "bz2" || name == "bzip2") return Packing::Bzip2;
  if (name == "txt" || name == "text" || name == "ascii") return Packing::Text;
  throw_invalid("its encoding cannot be read (raw, ascii, gzip and bzip2 can)");
}

int space_dimension(const std::string& space) {
  static const std::set<std::string> kThree{"right-anterior-superior",
                                            "ras",
                                            "left-anterior-superior",
                                            "las",
                                            "left-posterior-superior",
                                            "lps",
                                            "scanner-xyz",
                                            "3d-right-handed",
                                            "3d-left-handed"};
  static const std::set<std::string> kFour{"right-anterior-superior-time",
                                           "rast",
                                           "left-anterior-superior-time",
                                           "last",
                                           "left-posterior-superior-time",
                                           "lpst",
                                           "scanner-xyz-time",
                                           "3d-right-handed-time",
                                           "3d-left-handed-time"};
  if (kThree.count(space) != 0) return 3;
  if (kFour.count(space) != 0) return 4;
  throw_invalid("its header field \"space\" names a space that is not known");
}

/// "none" or "(x,y,z)", blanks allowed inside.
std::vector<std::vector<double>> vectors(std::string_view text, const std::string& field) {
  std::vector<std::vector<double>> out;
  for (std::string_view rest = trimmed(text); !rest.empty(); rest = trimmed(rest)) {
    if (rest.starts_with("none")) {
      out.emplace_back();
      rest.remove_prefix(4);
      continue;
    }
    const std::size_t end = rest.find(')');
    if (rest.front() != '(' || end == std::string_view::npos || out.size() >= kMostAxes) {
      throw_invalid("its header field \"" + field + "\" holds no vectors");
    }
    std::string inner(rest.substr(1, end - 1));
    std::replace(inner.begin(), inner.end(), ',', ' ');
    out.push_back(numbers(inner, field));
    if (out.back().empty()) throw_invalid("its header field \"" + field + "\" holds no vectors");
    rest.remove_prefix(end + 1);
  }
  return out;
}

class Parser {
 public:
  NrrdFields parse(std::string_view text) {
    std::string_view rest = text;
    const std::string_view magic = take_line(rest);
    if (!magic.starts_with("NRRD000") || magic.size() != 8 || magic[7] < '1' || magic[7] > '6') {
      throw_invalid("it is no NRRD file, or its header is damaged");
    }
    while (!rest.empty()) {
      const std::string_view line = take_line(rest);
      if (trimmed(line).empty()) break;
      if (line.front() == '#') continue;
      const std::size_t colon = line.find(':');
      if (colon == std::string_view::npos)
        throw_invalid("its header holds a line that is no field");
      const std::string_view value = line.substr(colon + 1);
      if (value.starts_with('=')) {
        fields_.keys.emplace(trimmed(line.substr(0, colon)), trimmed(value.substr(1)));
        continue;
      }
      const std::string name = lower(trimmed(line.substr(0, colon)));
      if (!seen_.insert(name).second) throw_invalid("its header names a field twice");
      field(name, trimmed(value));
      if (fields_.data_file && trimmed(value).starts_with("LIST")) break;  // then come file names
    }
    fields_.bytes = text.size() - rest.size();
    finish();
    return std::move(fields_);
  }

 private:
  template <class Set>
  void each_axis(std::size_t count, const std::string& name, Set&& set) {
    if (fields_.axes.empty())
      throw_invalid("its header names \"" + name + "\" before \"dimension\"");
    if (count != fields_.axes.size()) {
      throw_invalid("its header field \"" + name + "\" does not hold one value an axis");
    }
    for (std::size_t a = 0; a < count; ++a) set(fields_.axes[a], a);
  }
  void texts(std::string_view value, const std::string& name, std::string NrrdAxis::*member) {
    const auto list = quoted_words(value);
    each_axis(list.size(), name, [&](NrrdAxis& axis, std::size_t a) { axis.*member = list[a]; });
  }

  void field(const std::string& name, std::string_view value) {
    if (axis_field(name, value) || space_field(name, value)) return;
    data_field(name, value);
    // Other fields (content, centers, thicknesses, ...) say nothing that is needed.
  }

  /// Takes a field that says something of each axis; false if it does not.
  bool axis_field(const std::string& name, std::string_view value) {
    if (name == "dimension") {
      fields_.axes.resize(static_cast<std::size_t>(whole(value, name, 1, kMostAxes)));
      for (NrrdAxis& axis : fields_.axes) axis.spacing = kNaN;
    } else if (name == "sizes") {
      const auto list = words(value);
      each_axis(list.size(), name, [&](NrrdAxis& axis, std::size_t a) {
        axis.size = whole(list[a], name, 1, std::int64_t{1} << 31);
      });
    } else if (name == "spacings") {
      const auto list = numbers(value, name);
      each_axis(list.size(), name, [&](NrrdAxis& axis, std::size_t a) { axis.spacing = list[a]; });
    } else if (name == "kinds") {
      texts(value, name, &NrrdAxis::kind);
    } else if (name == "units") {
      texts(value, name, &NrrdAxis::unit);
    } else if (name == "labels") {
      texts(value, name, &NrrdAxis::label);
    } else if (name == "space directions") {
      const auto list = vectors(value, name);
      each_axis(list.size(), name,
                [&](NrrdAxis& axis, std::size_t a) { axis.direction = list[a]; });
    } else {
      return false;
    }
    return true;
  }

  /// Takes a field that says in which space the grid lies; false if it does not.
  bool space_field(const std::string& name, std::string_view value) {
    if (name == "space") {
      fields_.space = lower(value);
      fields_.space_dimension = space_dimension(fields_.space);
    } else if (name == "space dimension") {
      fields_.space_dimension = static_cast<int>(whole(value, name, 1, kMostAxes));
    } else if (name == "space origin") {
      const auto list = vectors(value, name);
      if (list.size() != 1) throw_invalid("its header field \"space origin\" is no vector");
      fields_.origin = list[0];
    } else if (name == "space units") {
      fields_.space_units = quoted_words(value);
    } else {
      return false;
    }
    return true;
  }

  /// Takes a field that says how and where the voxels are stored.
  void data_field(const std::string& name, std::string_view value) {
    if (name == "type") {
      if (lower(value) == "block") throw_invalid("its voxels are blocks of bytes, not numbers");
      fields_.type = voxel_type(lower(value));
    } else if (name == "encoding") {
      fields_.packing = packing(lower(value));
    } else if (name == "endian") {
      const std::string order = lower(value);
      if (order != "little" && order != "big") {
        throw_invalid("its byte order is none that is known");
      }
      fields_.big_endian = order == "big";
    } else if (name == "line skip" || name == "lineskip") {
      fields_.line_skip = whole(value, name, 0, kMostBytes);
    } else if (name == "byte skip" || name == "byteskip") {
      fields_.byte_skip = whole(value, name, -1, kMostBytes);
    } else if (name == "data file" || name == "datafile") {
      fields_.data_file = std::string(value);
    }
  }

  void finish() {
    for (const char* needed : {"dimension", "type", "sizes", "encoding"}) {
      if (seen_.count(needed) == 0) {
        throw_invalid(std::string("its header lacks the field \"") + needed + "\"");
      }
    }
    const bool bytes = fields_.packing != Packing::Text && bytes_of(fields_.type) > 1;
    if (bytes && !fields_.big_endian) throw_invalid("its header lacks the field \"endian\"");
    for (const NrrdAxis& axis : fields_.axes) {
      if (!axis.direction.empty() && std::ssize(axis.direction) != fields_.space_dimension) {
        throw_invalid("its space directions are not of the dimension of its space");
      }
    }
    if (!fields_.origin.empty() && std::ssize(fields_.origin) != fields_.space_dimension) {
      throw_invalid("its space origin is not of the dimension of its space");
    }
  }

  NrrdFields fields_;
  std::set<std::string> seen_;
};

}  // namespace

NrrdFields parse_nrrd_header(std::string_view text) { return Parser().parse(text); }

}  // namespace beatlas::formats
