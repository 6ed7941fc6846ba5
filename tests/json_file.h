#pragma once
/// JSON that lies in a file, for tests. It is parsed where all JSON is: the parser of nlohmann-json
/// takes longer to compile than most tests that use it.

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <nlohmann/json.hpp>

#include "runtime/base/json_text.h"

namespace beatlas::test {

/// `is_discarded()` if the file is missing or holds no JSON.
[[nodiscard]] inline nlohmann::json json_file(const std::filesystem::path& file,
                                              JsonComments comments = JsonComments::Refuse) {
  std::ifstream stream(file);
  return parse_json(std::string(std::istreambuf_iterator<char>(stream), {}), comments);
}

}  // namespace beatlas::test
