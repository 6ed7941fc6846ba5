#pragma once
/// Geometry and lists as JSON. Numbers are written with as many digits as read back the same.

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "pipeline/core/grid.h"

namespace beatlas::study {

/// The last phase that a file or a command may name, counted from 0: a package holds 1024.
inline constexpr int kLastPhase = 1023;

/// 16 numbers, row-major.
[[nodiscard]] nlohmann::json affine_to_json(const Affine& affine);
/// @throws Error{InvalidInput} naming `path` unless it is 16 numbers with last row 0 0 0 1 and an
/// invertible 3 x 3 part.
[[nodiscard]] Affine affine_from_json(const nlohmann::json& json, const std::string& path);

/// {"size": [3], "mm_from_index": [16]}
[[nodiscard]] nlohmann::json grid_to_json(const Grid& grid);
/// @throws Error{InvalidInput} naming `path`.
[[nodiscard]] Grid grid_from_json(const nlohmann::json& json, const std::string& path);

[[nodiscard]] Index3 index_from_json(const nlohmann::json& json, const std::string& path);
[[nodiscard]] std::vector<double> numbers_from_json(const nlohmann::json& json,
                                                    const std::string& path);
[[nodiscard]] std::vector<std::string> strings_from_json(const nlohmann::json& json,
                                                         const std::string& path);

}  // namespace beatlas::study
