#pragma once
/// The header of a MetaImage file. Pure: text in, value out.

#include <string>
#include <string_view>
#include <vector>

#include "pipeline/formats/image_file.h"
#include "pipeline/formats/voxel_data.h"

namespace beatlas::formats {

struct MetaFields {
  std::vector<std::int64_t> size;  ///< 3 or 4, each at least 1
  std::vector<double> spacing;     ///< one an axis
  std::vector<double> direction;   ///< square, a row an axis of the grid; empty: none told
  std::vector<double> origin;      ///< empty: none told
  double to_mm = 1;
  ScalarType type{};
  Packing packing = Packing::Raw;
  bool big_endian = false;
  double slope = 1;
  double intercept = 0;
  std::int64_t header_size = 0;  ///< bytes before the data in a file beside; -1: the data end it
  std::string data_file;         ///< value of ElementDataFile
  std::size_t bytes = 0;         ///< of the header in its file
};

/// @throws Error{InvalidInput} with a clause that follows "FILE: "
[[nodiscard]] MetaFields parse_meta_header(std::string_view text);
[[nodiscard]] Affine lps_from_index(const MetaFields& fields, std::string& note);
[[nodiscard]] ImageFileHeader frames_of(const MetaFields& fields);

}  // namespace beatlas::formats
