#include "runtime/haptics/heart_clock.h"

#include <algorithm>
#include <cmath>

#include "runtime/base/error.h"

namespace beatlas::haptics {

HeartClock::HeartClock(double period_s, const HeartOptions& options)
    : period_s_(period_s), settling_s_(options.settling_s) {
  if (!(period_s > 0) || !std::isfinite(period_s)) {
    throw_invalid("the heart's period must be a positive number of seconds");
  }
  if (!(settling_s_ >= 0.02 && settling_s_ <= 10)) {
    throw_invalid("the time in which the heart rate settles must be from 0.02 to 10 s");
  }
  const double per_min = options.rate_per_min.value_or(60 / period_s);
  if (options.rate_per_min && !(per_min >= 60 * kSlowestHz && per_min <= 60 * kFastestHz)) {
    throw_invalid("the heart rate must be from 10 to 300 beats a minute");
  }
  first_wish_.rate_hz = per_min / 60;
  rate_hz_ = first_wish_.rate_hz;
}

double HeartClock::phase() const noexcept { return beats_ - std::floor(beats_); }

void HeartClock::advance(double elapsed_s, const HeartWish& wish) noexcept {
  if (!(elapsed_s > 0) || !std::isfinite(elapsed_s)) return;
  const double kept = std::exp(-elapsed_s / settling_s_);
  const double asked = std::isfinite(wish.rate_hz) ? wish.rate_hz : first_wish_.rate_hz;
  // An atlas may itself be slower or quicker than a wish may ask for.
  const double slowest = std::min(kSlowestHz, first_wish_.rate_hz);
  const double fastest = std::max(kFastestHz, first_wish_.rate_hz);
  const double target = wish.paused ? 0 : std::clamp(asked, slowest, fastest);
  if (wish.hold_phase >= 0 && wish.hold_phase <= 1 && !wish.paused) {
    const double hold = wish.hold_phase - std::floor(wish.hold_phase);
    if (landing_ >= 0) {
      const double off = std::abs(landing_ - std::floor(landing_) - hold);
      if (std::min(off, 1 - off) > 1e-9) landing_ = -1;  // another phase is wished
    }
    if (landing_ < 0) {
      const double roll = rate_hz_ * settling_s_;
      double ahead = hold - phase();
      ahead -= std::floor(ahead);
      // The next passage that lies at least a pause's roll ahead, reached within this tick? The
      // roll grows while the rate does: together they close in at the wished rate.
      while (ahead < roll) ahead += 1;
      if (ahead - roll <= std::max(rate_hz_, target) * elapsed_s) landing_ = beats_ + ahead;
    }
    if (landing_ >= 0) {
      const double left = (landing_ - beats_) * kept;
      beats_ = landing_ - left;
      rate_hz_ = left / settling_s_;
      return;
    }
  } else {
    landing_ = -1;
  }
  beats_ += target * elapsed_s + (rate_hz_ - target) * settling_s_ * (1 - kept);
  rate_hz_ = target + (rate_hz_ - target) * kept;
}

void HeartClock::restore(const Memory& memory) noexcept {
  beats_ = memory[0];
  rate_hz_ = memory[1];
  landing_ = memory[2];
}

}  // namespace beatlas::haptics
