#include "pipeline/cli/fingerprint.h"

#include <bit>
#include <cstdint>
#include <cstdio>
#include <span>

#include "runtime/base/sha256.h"

namespace beatlas::cli {

std::string stack_sha256(const Cine& stack) {
  std::string text = "beatlas stack 1\n";
  const auto add_bits = [&](double value) {
    char digits[24];
    std::snprintf(digits, sizeof digits, "%016llx\n",
                  static_cast<unsigned long long>(std::bit_cast<std::uint64_t>(value)));
    text += digits;
  };
  for (int size : stack.grid().size) text += std::to_string(size) + "\n";
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      add_bits(stack.grid().mm_from_index.matrix()(row, column));
    }
  }
  add_bits(stack.rr_interval_s);
  for (double time_s : stack.frame_times_s) add_bits(time_s);
  for (const std::vector<float>& phase : stack.images.phases) {
    text += sha256_hex(std::as_bytes(std::span(phase))) + "\n";
  }
  return sha256_hex(std::as_bytes(std::span(text)));
}

}  // namespace beatlas::cli
