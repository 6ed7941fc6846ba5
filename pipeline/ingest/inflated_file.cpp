#include "pipeline/ingest/inflated_file.h"

#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <vector>

#include <sys/mman.h>
#include <unistd.h>
#include <zlib.h>

#include "runtime/base/plausible_size.h"

namespace beatlas::ingest {
namespace {

constexpr std::size_t kPreamble = 128;
constexpr std::size_t kGroupStart = kPreamble + 4;  // after "DICM"
constexpr std::size_t kLengthElement = 12;          // (0002,0000) UL 4 VALUE
constexpr std::size_t kMostMeta = 65536;

/// Length of preamble and group 2, from its group length; 0 if there is none.
std::size_t meta_end(const std::string& head) {
  if (head.size() < kGroupStart + kLengthElement || head.compare(kPreamble, 4, "DICM") != 0 ||
      head.compare(kGroupStart, 8, std::string("\x02\0\0\0UL\x04\0", 8)) != 0) {
    return 0;
  }
  std::uint32_t length = 0;
  for (int i = 3; i >= 0; --i) {
    length = length << 8 |
             static_cast<unsigned char>(head[kGroupStart + 8 + static_cast<std::size_t>(i)]);
  }
  return length > kMostMeta ? 0 : kGroupStart + kLengthElement + length;
}

bool write_all(int descriptor, const void* data, std::size_t size) {
  const char* at = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t written = ::write(descriptor, at, size);
    if (written <= 0) return false;
    at += written;
    size -= static_cast<std::size_t>(written);
  }
  return true;
}

enum class Inflated { Good, Damaged, TooLarge };

/// @param descriptor where the inflated bytes go; -1: nowhere, they are only looked at
Inflated inflate_to(int descriptor, const char* data, std::size_t size) {
  const std::uint64_t most = plausible_bytes(size, kImageUnpack);
  z_stream stream{};
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) return Inflated::Damaged;
  std::vector<unsigned char> block(1 << 16);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(data));
  stream.avail_in = static_cast<uInt>(size);
  int status = Z_OK;
  std::uint64_t total = 0;
  while (status == Z_OK && total <= most) {
    stream.next_out = block.data();
    stream.avail_out = static_cast<uInt>(block.size());
    status = inflate(&stream, Z_NO_FLUSH);
    const std::size_t made = block.size() - stream.avail_out;
    total += made;
    if (descriptor >= 0 && !write_all(descriptor, block.data(), made)) status = Z_BUF_ERROR;
  }
  inflateEnd(&stream);
  if (total > most) return Inflated::TooLarge;
  return status == Z_STREAM_END ? Inflated::Good : Inflated::Damaged;
}

}  // namespace

InflatedFile::InflatedFile(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  const std::string all((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  const std::size_t end = meta_end(all);
  const bool one_piece = all.size() <= std::numeric_limits<uInt>::max();  // as zlib takes it
  if (end == 0 || end >= all.size() || !one_piece) return;
  const char* packed = all.data() + end;
  const std::size_t size = all.size() - end;
  // Memory is taken for what is known to be sound.
  const Inflated state = inflate_to(-1, packed, size);
  too_large_ = state == Inflated::TooLarge;
  if (state != Inflated::Good) return;
  const int descriptor = memfd_create("inflated", MFD_CLOEXEC);
  if (descriptor < 0) return;
  if (!write_all(descriptor, all.data(), end) ||
      inflate_to(descriptor, packed, size) != Inflated::Good) {
    ::close(descriptor);
    return;
  }
  descriptor_ = descriptor;
  path_ = "/proc/self/fd/" + std::to_string(descriptor);
}

InflatedFile::~InflatedFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

}  // namespace beatlas::ingest
