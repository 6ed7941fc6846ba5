#pragma once
/// The header of a NRRD file. Pure: text in, value out.

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/formats/image_file.h"
#include "pipeline/formats/voxel_data.h"

namespace beatlas::formats {

/// An axis of the file, in its order.
struct NrrdAxis {
  std::int64_t size = 0;
  std::vector<double> direction;  ///< empty: it has none, it does not lie in space
  double spacing = 0;             ///< NaN: not told
  std::string kind;
  std::string unit;
  std::string label;
};

struct NrrdFields {
  std::vector<NrrdAxis> axes;  ///< 1..16
  ScalarType type{};
  Packing packing = Packing::Raw;
  std::optional<bool> big_endian;
  std::string space;        ///< lower case; empty: none
  int space_dimension = 0;  ///< 0: none
  std::vector<double> origin;
  std::vector<std::string> space_units;
  std::int64_t line_skip = 0;
  std::int64_t byte_skip = 0;               ///< -1: the data end with the file
  std::optional<std::string> data_file;     ///< value of the field
  std::size_t bytes = 0;                    ///< of the header in its file
  std::map<std::string, std::string> keys;  ///< key := value
};

/// @throws Error{InvalidInput} with a clause that follows "FILE: "
[[nodiscard]] NrrdFields parse_nrrd_header(std::string_view text);

/// Which axis is that of the images one after another; -1 in a 3-D file.
/// @throws Error{InvalidInput} unless three axes lie in space
[[nodiscard]] int frame_axis_of(const NrrdFields& fields);
/// The place of the other three, in their order. @throws Error{InvalidInput}
[[nodiscard]] Affine lps_from_index(const NrrdFields& fields, std::string& note);
/// What the header says of that axis.
[[nodiscard]] ImageFileHeader frames_of(const NrrdFields& fields);

}  // namespace beatlas::formats
