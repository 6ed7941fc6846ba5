#pragma once
#include <chrono>
#include <cstdint>

#include "runtime/device/device.h"

namespace beatlas::device {

enum class Pace : std::uint8_t {
  RealTime,  ///< a tick waits until it is due
  Fast,      ///< ticks follow each other at once; their times are the same
};

/// Times of the ticks of a loop of our own. A tick that is a period late or more is counted, and
/// the ticks it made impossible are left out, so that time never runs behind the clock.
class Pacer {
 public:
  /// @param rate_hz [1/s] > 0
  Pacer(Pace pace, double rate_hz);

  /// Waits for the next tick; its time since the first [s], a whole number of periods.
  [[nodiscard]] double next();
  [[nodiscard]] const RunReport& report() const { return report_; }

 private:
  using Clock = std::chrono::steady_clock;

  Pace pace_;
  double period_s_;
  std::int64_t slot_ = -1;
  Clock::time_point start_;
  RunReport report_;
};

}  // namespace beatlas::device
