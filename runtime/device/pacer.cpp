#include "runtime/device/pacer.h"

#include <algorithm>
#include <cmath>
#include <thread>

#include "runtime/base/error.h"

namespace beatlas::device {

Pacer::Pacer(Pace pace, double rate_hz) : pace_(pace), period_s_(1 / rate_hz) {
  if (!(rate_hz >= 1 && rate_hz <= 100000)) {
    throw_invalid("the rate of a servo must be from 1 to 100000 ticks a second");
  }
}

double Pacer::next() {
  ++report_.ticks;
  ++slot_;
  if (pace_ == Pace::Fast) return static_cast<double>(slot_) * period_s_;
  if (slot_ == 0) {
    start_ = Clock::now();
    return 0;
  }
  const auto due = [&] {
    return start_ + std::chrono::duration_cast<Clock::duration>(
                        std::chrono::duration<double>(static_cast<double>(slot_) * period_s_));
  };
  std::this_thread::sleep_until(due());
  const double late_s = std::chrono::duration<double>(Clock::now() - due()).count();
  report_.worst_late_s = std::max(report_.worst_late_s, late_s);
  if (late_s >= period_s_) {
    ++report_.late_ticks;
    slot_ += static_cast<std::int64_t>(std::floor(late_s / period_s_));
  }
  return static_cast<double>(slot_) * period_s_;
}

}  // namespace beatlas::device
