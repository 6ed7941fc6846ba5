#include "runtime/app/text.h"

#include <array>
#include <charconv>
#include <fstream>
#include <system_error>

#include "runtime/base/error.h"

namespace beatlas::app {

void append_number(std::string& text, double value) {
  std::array<char, 32> digits{};
  const double plain = value == 0 ? 0 : value;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), plain).ptr;
  text.append(digits.data(), end);
}

std::ifstream open_text(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw_invalid(file + " cannot be read; check its name and rights");
  return stream;
}

void write_file(const std::filesystem::path& file, const std::string& text) {
  // A device or pipe is written as it is; a file appears whole or not at all.
  std::error_code ignored;
  const bool in_place =
      std::filesystem::exists(file, ignored) && !std::filesystem::is_regular_file(file, ignored);
  const std::filesystem::path target =
      in_place ? file : std::filesystem::path(file.string() + ".part");
  std::ofstream stream(target, std::ios::binary | std::ios::trunc);
  stream << text;
  stream.close();
  bool written = static_cast<bool>(stream);
  if (written && !in_place) {
    std::error_code failed;
    std::filesystem::rename(target, file, failed);
    written = !failed;
  }
  if (!written) {
    if (!in_place) std::filesystem::remove(target, ignored);
    throw Error(ErrorCode::Machine,
                file.string() + " cannot be written; check its folder and the space left");
  }
}

}  // namespace beatlas::app
