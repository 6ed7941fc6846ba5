#include "pipeline/build/fingerprint.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstdio>
#include <span>

#include "pipeline/core/parallel.h"
#include "pipeline/core/stage_context.h"
#include "pipeline/ingest/source_files.h"
#include "pipeline/study/files.h"
#include "runtime/base/error.h"
#include "runtime/base/sha256.h"

namespace beatlas::build {
namespace fs = std::filesystem;
namespace {

constexpr auto kMark = "beatlas files 1\n";

std::vector<std::string> hashes_of(const std::vector<fs::path>& files) {
  std::vector<std::string> out(files.size());
  parallel_for(files.size(), [&](std::size_t at) { out[at] = study::sha256_of_file(files[at]); });
  return out;
}

/// How many, then each in a line.
std::string counted_lines(std::span<const std::string> hashes) {
  std::string out = std::to_string(hashes.size()) + "\n";
  for (const std::string& hash : hashes) out += hash + "\n";
  return out;
}

}  // namespace

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

std::optional<std::string> files_sha256(const std::vector<fs::path>& files) {
  try {
    std::string text = kMark;
    for (const std::string& hash : hashes_of(files)) text += counted_lines(std::span(&hash, 1));
    return sha256_hex(std::as_bytes(std::span(text)));
  } catch (const Error&) {
    return std::nullopt;  // the reader says what is wrong
  }
}

std::optional<std::string> source_sha256(const std::vector<fs::path>& sources) {
  try {
    StageContext context;
    const ingest::ReadFiles read = ingest::read_files(sources, context);
    if (read.images.empty()) return std::nullopt;
    std::vector<fs::path> files;
    for (const std::vector<fs::path>& image : read.images) {
      files.insert(files.end(), image.begin(), image.end());
    }
    std::vector<std::string> hashes = hashes_of(files);
    std::string text = kMark;
    if (!read.ordered) {
      std::sort(hashes.begin(), hashes.end());
      text += counted_lines(hashes);
    }
    std::size_t at = 0;
    for (std::size_t image = 0; read.ordered && image < read.images.size(); ++image) {
      const std::size_t count = read.images[image].size();
      text += counted_lines(std::span(hashes).subspan(at, count));
      at += count;
    }
    return sha256_hex(std::as_bytes(std::span(text)));
  } catch (const Error&) {
    return std::nullopt;  // the reader says what is wrong
  }
}

}  // namespace beatlas::build
