#pragma once
/// Force to zero within 10 ms of any stall. A servo that hangs or is not called leaves the last
/// force on the device; only another thread can take it off.

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <thread>

namespace beatlas::haptics {

struct WatchdogOptions {
  double limit_s = 0.006;   ///< [s] 0.002..1: without a beat for longer is a stall
  double period_s = 0.002;  ///< [s] 0.0005..0.1: how often it looks; limit + period <= 10 ms
};

class Watchdog {
 public:
  using Clock = std::chrono::steady_clock;

  /// @param on_stall takes the force off the device; called on the watchdog's thread, once a stall.
  /// @throws Error{InvalidInput} if an option is out of range or there is no function.
  Watchdog(std::function<void()> on_stall, const WatchdogOptions& options);
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

  /// From the first beat on it watches. Servo's thread, at the end of every tick: false if a stall
  /// was seen since the last beat; then the force of this tick is too old and must not be sent.
  [[nodiscard]] bool beat() noexcept { return beat_at(Clock::now()); }
  /// No stall is seen until the next beat: before a device is stopped on purpose.
  void rest() noexcept { last_beat_.store(kResting, std::memory_order_release); }
  [[nodiscard]] std::int64_t stalls() const noexcept {
    return stalls_.load(std::memory_order_acquire);
  }

  /// The same with the time told, for tests and for loops of one's own.
  [[nodiscard]] bool beat_at(Clock::time_point now) noexcept;
  /// What the thread does every period. @return whether this look saw a stall begin.
  bool look_at(Clock::time_point now);

 private:
  static constexpr std::int64_t kResting = -1;
  static constexpr std::int64_t kStalled = -2;

  std::function<void()> on_stall_;
  std::chrono::nanoseconds limit_;
  std::atomic<std::int64_t> last_beat_{kResting};  // [ns] of the clock, or one of the above
  std::atomic<std::int64_t> stalls_{0};
  std::jthread thread_;  // last: it ends before what it uses
};

}  // namespace beatlas::haptics
