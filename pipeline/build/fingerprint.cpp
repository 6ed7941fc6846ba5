#include "pipeline/build/fingerprint.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstdio>
#include <span>
#include <system_error>

#include "pipeline/core/parallel.h"
#include "pipeline/core/stage_context.h"
#include "pipeline/ingest/source_files.h"
#include "pipeline/study/files.h"
#include "runtime/base/error.h"
#include "runtime/base/sha256.h"

namespace beatlas::build {
namespace fs = std::filesystem;

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

std::optional<std::string> files_sha256(const std::vector<fs::path>& sources) {
  std::string text = "beatlas files 1\n";
  for (const fs::path& source : sources) {
    std::error_code error;
    std::vector<fs::path> files;
    if (fs::is_directory(source, error)) {
      try {
        StageContext context;
        files = ingest::files_under(source, context).files;
      } catch (const Error&) {
        return std::nullopt;  // the reader says what is wrong
      }
    } else {
      files.push_back(source);
    }
    std::vector<std::string> hashes(files.size());
    try {
      parallel_for(files.size(),
                   [&](std::size_t at) { hashes[at] = study::sha256_of_file(files[at]); });
    } catch (const Error&) {
      return std::nullopt;  // the reader says what is wrong
    }
    std::sort(hashes.begin(), hashes.end());
    text += std::to_string(hashes.size()) + "\n";
    for (const std::string& hash : hashes) text += hash + "\n";
  }
  return sha256_hex(std::as_bytes(std::span(text)));
}

}  // namespace beatlas::build
