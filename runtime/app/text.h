#pragma once
#include <filesystem>
#include <fstream>
#include <string>

#include <nlohmann/json.hpp>

#include "runtime/base/json_text.h"

namespace beatlas::app {

/// Shortest decimal that reads back as the same number; never "-0".
void append_number(std::string& text, double value);

/// @throws Error{InvalidInput} if it cannot be read, as a folder cannot.
[[nodiscard]] std::ifstream open_text(const std::string& file);
/// All of it. @throws Error{InvalidInput} if it cannot be read.
[[nodiscard]] std::string read_text(const std::string& file);

/// @throws Error{InvalidInput} if it cannot be read or is no JSON.
[[nodiscard]] nlohmann::json read_json_file(const std::string& file,
                                            JsonComments comments = JsonComments::Skip);

/// @throws Error{Machine} if it cannot be written whole.
void write_file(const std::filesystem::path& file, const std::string& text);

}  // namespace beatlas::app
