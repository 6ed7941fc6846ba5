#include "pipeline/phantom/noise.h"

#include <cmath>
#include <numbers>

namespace beatlas::phantom {
namespace {

constexpr double kUnit = 1.0 / 4294967296.0;

}  // namespace

std::array<std::uint32_t, 4> philox(std::array<std::uint32_t, 4> counter,
                                    std::array<std::uint32_t, 2> key) noexcept {
  constexpr std::uint64_t kMultiply0 = 0xD2511F53u;
  constexpr std::uint64_t kMultiply1 = 0xCD9E8D57u;
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t a = kMultiply0 * counter[0];
    const std::uint64_t b = kMultiply1 * counter[2];
    counter = {
        static_cast<std::uint32_t>(b >> 32) ^ counter[1] ^ key[0], static_cast<std::uint32_t>(b),
        static_cast<std::uint32_t>(a >> 32) ^ counter[3] ^ key[1], static_cast<std::uint32_t>(a)};
    key[0] += 0x9E3779B9u;
    key[1] += 0xBB67AE85u;
  }
  return counter;
}

std::array<double, 2> normal_pair(std::uint64_t index, std::uint32_t stream, std::uint32_t seed,
                                  Draw draw) noexcept {
  const auto bits = philox(
      {static_cast<std::uint32_t>(index), static_cast<std::uint32_t>(index >> 32), stream, 0},
      {seed, static_cast<std::uint32_t>(draw)});
  const double radius = std::sqrt(-2.0 * std::log((bits[0] + 0.5) * kUnit));
  const double angle = 2.0 * std::numbers::pi * (bits[1] + 0.5) * kUnit;
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

double uniform(std::uint64_t index, std::uint32_t seed, Draw draw) noexcept {
  const auto bits =
      philox({static_cast<std::uint32_t>(index), static_cast<std::uint32_t>(index >> 32), 0, 0},
             {seed, static_cast<std::uint32_t>(draw)});
  return (bits[0] + 0.5) * kUnit;
}

}  // namespace beatlas::phantom
