#include "tests/bench/alternatives_files.h"

#include <fstream>

#include <zstd.h>

#include "runtime/base/error.h"

namespace beatlas::bench {
namespace {

constexpr int kLevel = 3;

std::size_t checked(std::size_t result) {
  if (ZSTD_isError(result) != 0) {
    throw Error(ErrorCode::Machine, std::string("zstd failed: ") + ZSTD_getErrorName(result));
  }
  return result;
}

}  // namespace

void write_file(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream out(file, std::ios::binary);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) throw Error(ErrorCode::Machine, file.string() + " cannot be written");
}

std::string read_file(const std::filesystem::path& file) {
  std::string bytes(std::filesystem::file_size(file), '\0');
  std::ifstream in(file, std::ios::binary);
  in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!in) throw Error(ErrorCode::Machine, file.string() + " cannot be read");
  return bytes;
}

std::string zstd_packed(const std::string& bytes) {
  std::string out(ZSTD_compressBound(bytes.size()), '\0');
  out.resize(checked(ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), kLevel)));
  return out;
}

std::string zstd_unpacked(const std::string& frame) {
  const unsigned long long size = ZSTD_getFrameContentSize(frame.data(), frame.size());
  if (size == ZSTD_CONTENTSIZE_ERROR || size == ZSTD_CONTENTSIZE_UNKNOWN) {
    throw Error(ErrorCode::Machine, "a zstd frame does not say how much it holds");
  }
  std::string out(size, '\0');
  (void)checked(ZSTD_decompress(out.data(), out.size(), frame.data(), frame.size()));
  return out;
}

}  // namespace beatlas::bench
