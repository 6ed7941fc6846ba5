#pragma once
#include <algorithm>

#include "runtime/atlas/bytes.h"

namespace beatlas::atlas {

/// Limits on what a frame may unpack to, beside what the payload's own counts say: a static
/// 30-phase field packs about 100 : 1, so 1000 : 1 is out of reach of honest content.
inline constexpr std::uint64_t kMaxUnpackRatio = 1000;
inline constexpr std::uint64_t kMaxUnpackFloor = std::uint64_t{1} << 20;
inline constexpr std::uint64_t kMaxUnpackBytes = std::uint64_t{1} << 30;

/// The most that a frame of `size` bytes may stand for.
[[nodiscard]] constexpr std::uint64_t plausible_bytes(std::size_t size) noexcept {
  return std::min(kMaxUnpackBytes, kMaxUnpackFloor + kMaxUnpackRatio * size);
}

/// Unpacks exactly one zstd frame that says how much it holds.
/// @throws Error{InvalidInput} if it is damaged, says nothing of its size, is followed by other
/// bytes, or holds more than the limits above.
[[nodiscard]] Bytes zstd_unpack(ByteView frame);

}  // namespace beatlas::atlas
