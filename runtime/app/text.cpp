#include "runtime/app/text.h"

#include <array>
#include <charconv>
#include <fstream>
#include <iterator>
#include <system_error>

#include "runtime/base/error.h"
#include "runtime/base/replace_file.h"

namespace beatlas::app {

void append_number(std::string& text, double value) {
  std::array<char, 32> digits{};
  const double plain = value == 0 ? 0 : value;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), plain).ptr;
  text.append(digits.data(), end);
}

std::ifstream open_text(const std::string& file) {
  // A folder opens as a file does, and fails only when it is read.
  std::error_code ignored;
  const bool folder = std::filesystem::is_directory(file, ignored);
  std::ifstream stream(file, std::ios::binary);
  if (folder || !stream) throw_invalid(file + " cannot be read; check its name and rights");
  return stream;
}

std::string read_text(const std::string& file) {
  std::ifstream stream = open_text(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

nlohmann::json read_json_file(const std::string& file, JsonComments comments) {
  nlohmann::json document = parse_json(read_text(file), comments);
  if (document.is_discarded()) throw_invalid(file + " is not valid JSON");
  return document;
}

void write_file(const std::filesystem::path& file, const std::string& text) {
  // A device or pipe is written as it is; a file appears whole or not at all.
  std::error_code ignored;
  const bool in_place =
      std::filesystem::exists(file, ignored) && !std::filesystem::is_regular_file(file, ignored);
  if (!in_place) return replace_file(file, text);
  std::ofstream stream(file, std::ios::binary | std::ios::trunc);
  stream << text;
  stream.close();
  if (!stream) {
    throw Error(ErrorCode::Machine, file.string() + " cannot be written; check what it leads to");
  }
}

}  // namespace beatlas::app
