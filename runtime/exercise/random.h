#pragma once
/// Numbers that are the same on every machine: the standard's distributions are not.

#include <cstdint>

namespace beatlas::exercise {

/// SplitMix64 (Steele, Lea and Flood, OOPSLA 2014).
class Random {
 public:
  explicit Random(std::uint64_t seed) noexcept : state_(seed) {}

  /// 0 <= x < 1
  [[nodiscard]] double unit() noexcept {
    constexpr double kStep = 0x1p-53;
    return kStep * static_cast<double>(next() >> 11U);
  }
  [[nodiscard]] double within(double low, double high) noexcept {
    return low + (high - low) * unit();
  }
  /// 0 <= n < count. @pre count > 0
  [[nodiscard]] std::size_t below(std::size_t count) noexcept {
    return static_cast<std::size_t>(unit() * static_cast<double>(count));
  }

 private:
  [[nodiscard]] std::uint64_t next() noexcept {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15U;
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
    return z ^ (z >> 31U);
  }
  std::uint64_t state_;
};

}  // namespace beatlas::exercise
