#include "pipeline/study/json_values.h"

#include <cmath>

#include "runtime/base/error.h"
#include "runtime/base/json_object.h"

namespace beatlas::study {
using nlohmann::json;

json affine_to_json(const Affine& affine) {
  json out = json::array();
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) out.push_back(affine.matrix()(row, column));
  }
  return out;
}

std::vector<double> numbers_from_json(const json& value, const std::string& path) {
  if (!value.is_array()) throw_invalid(path + " must be a list of numbers");
  std::vector<double> out;
  for (const json& number : value) {
    if (!number.is_number()) throw_invalid(path + " must be a list of numbers");
    out.push_back(number.get<double>());
  }
  return out;
}

Affine affine_from_json(const json& value, const std::string& path) {
  const std::vector<double> numbers = numbers_from_json(value, path);
  if (numbers.size() != 16) throw_invalid(path + " must be 16 numbers, row by row");
  Affine out;
  for (int at = 0; at < 16; ++at) {
    out.matrix()(at / 4, at % 4) = numbers[static_cast<std::size_t>(at)];
  }
  const double determinant = out.linear().determinant();
  if (out.matrix().row(3) != Eigen::RowVector4d(0, 0, 0, 1) || !std::isfinite(determinant) ||
      determinant == 0 || !out.matrix().allFinite()) {
    throw_invalid(path + " is no invertible affine map");
  }
  return out;
}

Index3 index_from_json(const json& value, const std::string& path) {
  const std::vector<double> numbers = numbers_from_json(value, path);
  if (numbers.size() != 3) throw_invalid(path + " must be 3 whole numbers");
  Index3 out{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double number = numbers[axis];
    if (!(number >= 0 && number <= 65535) || number != std::floor(number)) {
      throw_invalid(path + " must be 3 whole numbers from 0 to 65535");
    }
    out[axis] = static_cast<int>(number);
  }
  return out;
}

json grid_to_json(const Grid& grid) {
  return {{"size", grid.size}, {"mm_from_index", affine_to_json(grid.mm_from_index)}};
}

Grid grid_from_json(const json& value, const std::string& path) {
  JsonObject object(value, path);
  Grid grid;
  grid.size = index_from_json(object.at("size"), path + "/size");
  grid.mm_from_index = affine_from_json(object.at("mm_from_index"), path + "/mm_from_index");
  object.finish();
  return grid;
}

std::vector<std::string> strings_from_json(const json& value, const std::string& path) {
  if (!value.is_array()) throw_invalid(path + " must be a list of strings");
  std::vector<std::string> out;
  for (const json& text : value) {
    if (!text.is_string()) throw_invalid(path + " must be a list of strings");
    out.push_back(text.get<std::string>());
  }
  return out;
}

}  // namespace beatlas::study
