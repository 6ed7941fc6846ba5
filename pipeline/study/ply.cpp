#include "pipeline/study/ply.h"

#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>

#include "pipeline/study/files.h"
#include "runtime/base/error.h"

namespace beatlas::study {
namespace fs = std::filesystem;
static_assert(std::endian::native == std::endian::little, "PLY is copied as little-endian bytes");
namespace {

enum class Scalar { Int8, UInt8, Int16, UInt16, Int32, UInt32, Float, Double };

std::optional<Scalar> scalar_of(const std::string& name) {
  if (name == "char" || name == "int8") return Scalar::Int8;
  if (name == "uchar" || name == "uint8") return Scalar::UInt8;
  if (name == "short" || name == "int16") return Scalar::Int16;
  if (name == "ushort" || name == "uint16") return Scalar::UInt16;
  if (name == "int" || name == "int32") return Scalar::Int32;
  if (name == "uint" || name == "uint32") return Scalar::UInt32;
  if (name == "float" || name == "float32") return Scalar::Float;
  if (name == "double" || name == "float64") return Scalar::Double;
  return std::nullopt;
}

struct Property {
  std::string name;
  Scalar type{};
  std::optional<Scalar> count_type;  ///< set for a list
};

struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  bool ascii = false;
  std::vector<Element> elements;
};

/// Takes scalars off the front of the file's body.
class Body {
 public:
  Body(std::string_view rest, bool ascii) : rest_(rest), ascii_(ascii) {}

  double take(Scalar type) { return ascii_ ? take_word() : take_binary(type); }

 private:
  double take_word() {
    const std::size_t first = rest_.find_first_not_of(" \t\r\n");
    if (first == std::string_view::npos) throw_invalid("is cut short");
    rest_.remove_prefix(first);
    double value = 0;
    const auto [end, failure] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), value);
    if (failure != std::errc{}) throw_invalid("has a word where a number should be");
    rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
    return value;
  }

  template <class T>
  double copy() {
    if (rest_.size() < sizeof(T)) throw_invalid("is cut short");
    T value{};
    std::memcpy(&value, rest_.data(), sizeof(T));
    rest_.remove_prefix(sizeof(T));
    return static_cast<double>(value);
  }

  double take_binary(Scalar type) {
    switch (type) {
      case Scalar::Int8:
        return copy<std::int8_t>();
      case Scalar::UInt8:
        return copy<std::uint8_t>();
      case Scalar::Int16:
        return copy<std::int16_t>();
      case Scalar::UInt16:
        return copy<std::uint16_t>();
      case Scalar::Int32:
        return copy<std::int32_t>();
      case Scalar::UInt32:
        return copy<std::uint32_t>();
      case Scalar::Float:
        return copy<float>();
      case Scalar::Double:
        return copy<double>();
    }
    return 0;
  }

  std::string_view rest_;
  bool ascii_;
};

std::string take_line(std::string_view& rest) {
  const std::size_t end = rest.find('\n');
  if (end == std::string_view::npos) throw_invalid("has no end_header");
  std::string line(rest.substr(0, end));
  rest.remove_prefix(end + 1);
  if (!line.empty() && line.back() == '\r') line.pop_back();
  return line;
}

Property parse_property(std::istringstream& words) {
  Property property;
  std::string type;
  words >> type;
  if (type == "list") {
    std::string count_type;
    words >> count_type >> type;
    property.count_type = scalar_of(count_type);
    if (!property.count_type) throw_invalid("has a list of unknown type");
  }
  words >> property.name;
  const std::optional<Scalar> scalar = scalar_of(type);
  if (!scalar || property.name.empty()) throw_invalid("has a property of unknown type");
  property.type = *scalar;
  return property;
}

Header parse_header(std::string_view& rest) {
  if (rest.substr(0, 3) != "ply") throw_invalid("is no PLY file");
  take_line(rest);
  Header header;
  for (;;) {
    std::istringstream words(take_line(rest));
    std::string key;
    words >> key;
    if (key == "end_header") return header;
    if (key == "format") {
      std::string format;
      words >> format;
      header.ascii = format == "ascii";
      if (!header.ascii && format != "binary_little_endian") {
        throw_invalid("is " + format + "; save it as ascii or binary_little_endian");
      }
    } else if (key == "element") {
      Element element;
      // Every element takes a byte or more of the body, so a larger count is no file of ours.
      if (!(words >> element.name >> element.count) || element.count > rest.size()) {
        throw_invalid("has an element without a sound count");
      }
      header.elements.push_back(std::move(element));
    } else if (key == "property") {
      if (header.elements.empty()) throw_invalid("has a property before any element");
      header.elements.back().properties.push_back(parse_property(words));
    }
  }
}

std::uint32_t to_index(double value) {
  if (!(value >= 0 && value <= 4294967295.0) || value != std::floor(value)) {
    throw_invalid("has a vertex index that is no whole number");
  }
  return static_cast<std::uint32_t>(value);
}

void read_vertex(const Element& element, Body& body, TriangleMesh& mesh) {
  Vec3f vertex(NAN, NAN, NAN);
  for (const Property& property : element.properties) {
    if (property.count_type) throw_invalid("has a list among the vertex properties");
    const auto value = static_cast<float>(body.take(property.type));
    if (property.name == "x") vertex[0] = value;
    if (property.name == "y") vertex[1] = value;
    if (property.name == "z") vertex[2] = value;
  }
  if (!vertex.allFinite()) throw_invalid("has a vertex without finite x, y and z");
  mesh.vertices.push_back(vertex);
}

void read_other(const Element& element, Body& body, bool is_face, TriangleMesh& mesh) {
  for (const Property& property : element.properties) {
    const double count = property.count_type ? body.take(*property.count_type) : 1;
    const bool corners = is_face && property.count_type &&
                         (property.name == "vertex_indices" || property.name == "vertex_index");
    if (corners && count != 3) throw_invalid("has a face that is no triangle");
    if (!(count >= 0)) throw_invalid("has a list of negative length");
    std::array<std::uint32_t, 3> triangle{};
    for (double at = 0; at < count; ++at) {
      const double value = body.take(property.type);
      if (corners) triangle[static_cast<std::size_t>(at)] = to_index(value);
    }
    if (corners) mesh.triangles.push_back(triangle);
  }
}

TriangleMesh parse(std::string_view rest) {
  const Header header = parse_header(rest);
  Body body(rest, header.ascii);
  TriangleMesh mesh;
  for (const Element& element : header.elements) {
    for (std::size_t at = 0; at < element.count && !element.properties.empty(); ++at) {
      if (element.name == "vertex") {
        read_vertex(element, body, mesh);
      } else {
        read_other(element, body, element.name == "face", mesh);
      }
    }
  }
  if (mesh.triangles.empty()) throw_invalid("has no triangles");
  for (const auto& triangle : mesh.triangles) {
    for (std::uint32_t corner : triangle) {
      if (corner >= mesh.vertices.size()) throw_invalid("has an index beyond its vertices");
    }
  }
  return mesh;
}

template <class T>
void append(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

}  // namespace

void write_ply(const fs::path& file, const TriangleMesh& mesh) {
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\ncomment workspace frame, mm\nelement vertex " +
      std::to_string(mesh.vertices.size()) +
      "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
      std::to_string(mesh.triangles.size()) +
      "\nproperty list uchar int vertex_indices\nend_header\n";
  bytes.reserve(bytes.size() + 12 * mesh.vertices.size() + 13 * mesh.triangles.size());
  for (const Vec3f& vertex : mesh.vertices) {
    for (int axis = 0; axis < 3; ++axis) append(bytes, vertex[axis]);
  }
  for (const auto& triangle : mesh.triangles) {
    append(bytes, std::uint8_t{3});
    for (std::uint32_t corner : triangle) append(bytes, corner);
  }
  write_text(file, bytes);
}

TriangleMesh read_ply(const fs::path& file) {
  const std::vector<std::byte> bytes = read_bytes(file);
  try {
    return parse({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  } catch (const Error& error) {
    throw Error(error.code(), file.string() + " " + error.what());
  }
}

}  // namespace beatlas::study
