#pragma once
#include "runtime/atlas/bytes.h"
#include "runtime/base/plausible_size.h"

namespace beatlas::atlas {

/// The most that a frame of `size` bytes may stand for, beside what the payload's own counts say.
[[nodiscard]] constexpr std::uint64_t plausible_bytes(std::size_t size) noexcept {
  return beatlas::plausible_bytes(size, kPayloadUnpack);
}

/// Unpacks exactly one zstd frame that says how much it holds.
/// @throws Error{InvalidInput} if it is damaged, says nothing of its size, is followed by other
/// bytes, or holds more than is plausible.
[[nodiscard]] Bytes zstd_unpack(ByteView frame);

}  // namespace beatlas::atlas
