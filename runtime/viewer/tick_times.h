#pragma once
/// Times of ticks, counted without a lock.

#include <array>
#include <atomic>
#include <cstdint>

namespace beatlas::viewer {

/// Time of a clock that only goes on [ns].
[[nodiscard]] std::int64_t clock_ns() noexcept;

/// Counts in steps of a twelfth of an octave (6 %), from 64 ns to a second and more. One thread
/// adds, any thread asks.
class TickTimes {
 public:
  void add(std::int64_t ns) noexcept;
  void clear() noexcept;
  [[nodiscard]] std::uint64_t count() const noexcept;
  /// [us]: as long or shorter were at least `share` of them, 0..1; the upper end of its step. 0
  /// without any.
  [[nodiscard]] double quantile_us(double share) const noexcept;

 private:
  static constexpr int kSteps = 300;
  std::array<std::atomic<std::uint32_t>, kSteps> counts_{};
};

}  // namespace beatlas::viewer
