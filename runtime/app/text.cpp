#include "runtime/app/text.h"

#include <array>
#include <charconv>
#include <fstream>

#include "runtime/base/error.h"

namespace beatlas::app {

void append_number(std::string& text, double value) {
  std::array<char, 32> digits{};
  const double plain = value == 0 ? 0 : value;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), plain).ptr;
  text.append(digits.data(), end);
}

void write_file(const std::filesystem::path& file, const std::string& text) {
  std::ofstream stream(file, std::ios::binary | std::ios::trunc);
  stream << text;
  stream.close();
  if (!stream) {
    throw Error(ErrorCode::Machine,
                file.string() + " cannot be written; check its folder and the space left");
  }
}

}  // namespace beatlas::app
