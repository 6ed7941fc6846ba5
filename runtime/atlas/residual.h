#pragma once
#include <cstdint>

namespace beatlas::atlas {

/// 0, -1, 1, -2, ... <-> 0, 1, 2, 3, ... on 16 bits.
[[nodiscard]] constexpr std::uint16_t zigzag(std::uint16_t value) noexcept {
  return static_cast<std::uint16_t>((value << 1) ^ ((value & 0x8000U) != 0 ? 0xFFFFU : 0U));
}
[[nodiscard]] constexpr std::uint16_t unzigzag(std::uint16_t code) noexcept {
  return static_cast<std::uint16_t>((code >> 1) ^ ((code & 1U) != 0 ? 0xFFFFU : 0U));
}

}  // namespace beatlas::atlas
