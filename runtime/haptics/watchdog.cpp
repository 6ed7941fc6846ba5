#include "runtime/haptics/watchdog.h"

#include <utility>

#include "runtime/base/error.h"

namespace beatlas::haptics {
namespace {

std::chrono::nanoseconds nanoseconds(double seconds) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
      std::chrono::duration<double>(seconds));
}

std::int64_t count(Watchdog::Clock::time_point now) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(now.time_since_epoch()).count();
}

}  // namespace

Watchdog::Watchdog(std::function<void()> on_stall, const WatchdogOptions& options)
    : on_stall_(std::move(on_stall)), limit_(nanoseconds(options.limit_s)) {
  if (!on_stall_) throw_invalid("a watchdog needs to be told how the force is taken off");
  if (!(options.limit_s >= 0.002 && options.limit_s <= 1)) {
    throw_invalid("the watchdog's limit must be from 0.002 to 1 s");
  }
  if (!(options.period_s >= 0.0005 && options.period_s <= 0.1)) {
    throw_invalid("the watchdog's period must be from 0.0005 to 0.1 s");
  }
  const std::chrono::nanoseconds period = nanoseconds(options.period_s);
  thread_ = std::jthread([this, period](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      std::this_thread::sleep_for(period);
      (void)look_at(Clock::now());
    }
  });
}

bool Watchdog::beat_at(Clock::time_point now) noexcept {
  return last_beat_.exchange(count(now), std::memory_order_acq_rel) != kStalled;
}

bool Watchdog::look_at(Clock::time_point now) {
  std::int64_t last = last_beat_.load(std::memory_order_acquire);
  if (last < 0 || count(now) - last <= limit_.count()) return false;
  // A beat that comes in between wins: then nothing hangs.
  if (!last_beat_.compare_exchange_strong(last, kStalled, std::memory_order_acq_rel)) return false;
  stalls_.fetch_add(1, std::memory_order_release);
  on_stall_();
  return true;
}

}  // namespace beatlas::haptics
