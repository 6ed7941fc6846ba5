#include "runtime/atlas/zstd_frame.h"

#include <zstd.h>

namespace beatlas::atlas {

Bytes zstd_unpack(ByteView frame) {
  const char* damaged = "the compressed payload is damaged; build the package again";
  const unsigned long long size = ZSTD_getFrameContentSize(frame.data(), frame.size());
  if (size == ZSTD_CONTENTSIZE_UNKNOWN || size == ZSTD_CONTENTSIZE_ERROR) throw_invalid(damaged);
  const std::size_t packed = ZSTD_findFrameCompressedSize(frame.data(), frame.size());
  if (ZSTD_isError(packed) != 0 || packed != frame.size()) throw_invalid(damaged);
  const std::uint64_t limit = plausible_bytes(frame.size());
  if (size > limit) {
    throw_invalid("the compressed payload claims " + std::to_string(size) + " bytes, more than " +
                  std::to_string(limit) + " are plausible for its size; build the package again");
  }
  Bytes out(static_cast<std::size_t>(size));
  const std::size_t got = ZSTD_decompress(out.data(), out.size(), frame.data(), frame.size());
  if (ZSTD_isError(got) != 0 || got != out.size()) throw_invalid(damaged);
  return out;
}

}  // namespace beatlas::atlas
