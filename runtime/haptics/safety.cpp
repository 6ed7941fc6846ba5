#include "runtime/haptics/safety.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "runtime/base/error.h"

namespace beatlas::haptics {
namespace {

void check_range(const char* name, double value, double low, double high) {
  if (value >= low && value <= high) return;
  std::ostringstream text;
  text << "the safety stage's " << name << " must be from " << low << " to " << high;
  throw_invalid(text.str());
}

}  // namespace

SafetyStage::SafetyStage(const SafetyOptions& options) : options_(options) {
  check_range("peak_n", options.peak_n, 0.05, 40);
  check_range("slew_n_per_s", options.slew_n_per_s, 1, 5000);
  check_range("max_depth_mm", options.max_depth_mm, 0.1, 100);
  check_range("start_ramp_s", options.start_ramp_s, 0, 10);
  check_range("max_gap_s", options.max_gap_s, 0.001, 1);
}

void SafetyStage::restart() noexcept {
  stopped_ = false;
  state_ = State::Off;
}

SafetyStage::Memory SafetyStage::memory() const noexcept {
  return {last_n_.x(),         last_n_.y(),   last_n_.z(),
          last_time_s_,        start_time_s_, static_cast<double>(state_),
          stopped_ ? 1.0 : 0.0};
}

void SafetyStage::restore(const Memory& memory) noexcept {
  last_n_ = Vec3(memory[0], memory[1], memory[2]);
  last_time_s_ = memory[3];
  start_time_s_ = memory[4];
  // A file of ticks may hold any number here; what is no state is none.
  const auto last = static_cast<double>(State::Stands);
  state_ = memory[5] >= 0 && memory[5] <= last ? static_cast<State>(memory[5]) : State::Off;
  stopped_ = memory[6] != 0;
}

SafeForce SafetyStage::apply(const Vec3& wanted_n, double depth_mm, double time_s,
                             bool valid) noexcept {
  const bool sane = valid && !stopped_ && wanted_n.allFinite() && std::isfinite(depth_mm) &&
                    std::isfinite(time_s);
  const bool running = state_ == State::Running || state_ == State::Repeated;
  const double elapsed_s = running ? time_s - last_time_s_ : 0;
  const bool repeats = state_ != State::Off && time_s == last_time_s_;
  const bool stands = repeats && state_ != State::Running;
  // The comparison's form turns away what is no number, too.
  if (!sane || stands || !(elapsed_s >= 0 && elapsed_s <= options_.max_gap_s)) {
    state_ = stands ? State::Stands : State::Off;
    last_n_ = Vec3::Zero();
    return {};
  }
  if (!running) {
    start_time_s_ = time_s;
    last_n_ = Vec3::Zero();
  }
  state_ = repeats ? State::Repeated : State::Running;
  last_time_s_ = time_s;

  SafeForce safe{wanted_n, TickStatus::Ok};
  const auto scale = [&safe](double factor) {
    safe.force_n *= factor;
    safe.status = TickStatus::Limited;
  };
  if (depth_mm > options_.max_depth_mm) scale(options_.max_depth_mm / depth_mm);
  const double running_s = time_s - start_time_s_;
  if (running_s < options_.start_ramp_s) scale(running_s / options_.start_ramp_s);
  // stableNorm: squares of large forces must not overflow.
  const double size = safe.force_n.stableNorm();
  if (size > options_.peak_n) {
    safe.force_n /= size;
    scale(options_.peak_n);
  }
  const Vec3 change = safe.force_n - last_n_;
  const double most = options_.slew_n_per_s * elapsed_s;
  const double wanted_change = change.norm();
  if (wanted_change > most) {
    safe.force_n = last_n_ + most / wanted_change * change;
    safe.status = TickStatus::Limited;
  }
  last_n_ = safe.force_n;
  return safe;
}

Vec3 TorqueStage::apply(const Vec3& torque_n_mm, const Vec3& model_n, const SafeForce& safe,
                        double time_s) noexcept {
  const double before_s = std::exchange(last_time_s_, time_s);
  const bool good = safe.status != TickStatus::Fault && torque_n_mm.allFinite();
  const bool went_on = std::exchange(running_, good);
  if (!good) {
    last_n_mm_ = Vec3::Zero();
    return last_n_mm_;
  }
  // A restart may find the device's clock anywhere: no time has gone by then.
  const double elapsed_s = went_on ? std::max(0.0, time_s - before_s) : 0;
  // Where opposite walls push, the force may be all but nothing and the torque is not.
  const double force_n = model_n.stableNorm();
  const double share = safe.status == TickStatus::Ok || force_n == 0
                           ? 1.0
                           : std::min(1.0, safe.force_n.stableNorm() / force_n);
  const Vec3 change = share * torque_n_mm - last_n_mm_;
  const double most = slew_n_mm_per_s_ * elapsed_s;
  const double wanted = change.stableNorm();
  last_n_mm_ += wanted > most ? Vec3(most / wanted * change) : change;
  return last_n_mm_;
}

}  // namespace beatlas::haptics
