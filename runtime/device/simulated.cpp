#include "runtime/device/simulated.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "runtime/base/error.h"

namespace beatlas::device {
namespace {

void require(bool holds, const char* message) {
  if (!holds) throw_invalid(message);
}

}  // namespace

Vec3 HandPath::position_m(double t) const {
  return anchor_m +
         direction * (offset_m + amplitude_m * std::sin(2 * std::numbers::pi * frequency_hz * t));
}

Vec3 HandPath::velocity_m_s(double t) const {
  const double w = 2 * std::numbers::pi * frequency_hz;
  return direction * (amplitude_m * w * std::cos(w * t));
}

SimulatedDevice::SimulatedDevice(const SimulatedOptions& options) : options_(options) {
  const HandPath& path = options.path;
  require(path.anchor_m.allFinite() && path.direction.allFinite() && path.direction.norm() > 0,
          "the simulated hand needs a point and a direction that is not zero");
  require(std::isfinite(path.offset_m) && path.amplitude_m >= 0 && path.frequency_hz >= 0 &&
              std::isfinite(path.amplitude_m) && std::isfinite(path.frequency_hz),
          "the simulated hand's amplitude and frequency must be 0 or more");
  const HandModel& hand = options.hand;
  require(hand.mass_kg == 0 || (hand.mass_kg >= 0.001 && hand.mass_kg <= 10),
          "the simulated hand's mass must be 0 or from 0.001 to 10 kg");
  require(hand.stiffness_n_per_m >= 0 && hand.damping_n_s_per_m >= 0 &&
              std::isfinite(hand.stiffness_n_per_m) && std::isfinite(hand.damping_n_s_per_m),
          "the simulated hand's stiffness and damping must be 0 or more");
  const DeviceFaults& faults = options.faults;
  require(faults.viscous_n_s_per_m >= 0 && faults.coulomb_n >= 0 && faults.encoder_step_m >= 0 &&
              std::isfinite(faults.viscous_n_s_per_m) && std::isfinite(faults.coulomb_n) &&
              std::isfinite(faults.encoder_step_m),
          "the simulated device's friction and encoder step must be 0 or more");
  require(faults.delay_ticks >= 0 && faults.delay_ticks <= 100,
          "the simulated device's delay must be from 0 to 100 ticks");
  require(options.seconds > 0 && std::isfinite(options.seconds),
          "the simulated device must play for more than 0 seconds");
  options_.path.direction.normalize();
}

namespace {

// A step of m v' = k (p - x) + c (p' - v) - b v + F by the implicit midpoint rule, dry friction as
// the impulse that it can take at most.
void step_hand(const SimulatedOptions& options, double from_s, double to_s, const Vec3& force_n,
               DeviceState& state) {
  const HandPath& path = options.path;
  const HandModel& hand = options.hand;
  const double dt = to_s - from_s;
  const Vec3 target = 0.5 * (path.position_m(to_s) + path.position_m(from_s));
  const Vec3 drift = 0.5 * (path.velocity_m_s(to_s) + path.velocity_m_s(from_s));
  // Velocity and place at the middle of the step: x_m = x + dt/2 v_m.
  const double inertia = 2 * hand.mass_kg;
  Vec3 impulse =
      inertia * state.velocity_m_s + dt * (hand.stiffness_n_per_m * (target - state.position_m) +
                                           hand.damping_n_s_per_m * drift + force_n);
  const double most = dt * options.faults.coulomb_n;
  if (most > 0) impulse *= std::max(0.0, 1 - most / std::max(impulse.norm(), 1e-300));
  const Vec3 middle =
      impulse / (inertia + dt * (hand.damping_n_s_per_m + options.faults.viscous_n_s_per_m) +
                 0.5 * dt * dt * hand.stiffness_n_per_m);
  state.position_m += dt * middle;
  state.velocity_m_s = 2 * middle - state.velocity_m_s;
  // The rule alone would let a stuck mass go on with its velocity turned round.
  if (most > 0 && middle.isZero()) state.velocity_m_s.setZero();
}

// What the encoder tells of `real`; `told` is what it told at the tick before.
DeviceState told_by_encoder(const DeviceState& real, double step_m, double elapsed_s,
                            const DeviceState& told) {
  DeviceState out = real;
  if (step_m > 0) {
    out.position_m = step_m * (real.position_m / step_m).array().round();
    out.velocity_m_s =
        elapsed_s > 0 ? Vec3((out.position_m - told.position_m) / elapsed_s) : Vec3::Zero();
  }
  return out;
}

}  // namespace

RunReport SimulatedDevice::run(const ServoFn& servo, std::stop_token stop) {
  const HandPath& path = options_.path;
  const HandModel& hand = options_.hand;
  const DeviceFaults& faults = options_.faults;
  Pacer pacer(options_.pace, options_.rate_hz);
  DeviceState state;
  state.position_m = path.position_m(0);
  state.velocity_m_s = path.velocity_m_s(0);
  DeviceState told;
  // Forces on their way, oldest at `due`.
  std::vector<Vec3> under_way(static_cast<std::size_t>(faults.delay_ticks) + 1, Vec3::Zero());
  std::size_t due = 0;
  RunReport report;
  const auto ticks = static_cast<std::int64_t>(std::ceil(options_.seconds * options_.rate_hz));
  while (!stop.stop_requested()) {
    const double t = pacer.next();
    if (std::llround(t * options_.rate_hz) >= ticks) break;
    const double elapsed_s = t - state.time_s;
    if (hand.mass_kg > 0) {
      step_hand(options_, state.time_s, t, under_way[due], state);
    } else {
      state.position_m = path.position_m(t);
      state.velocity_m_s = path.velocity_m_s(t);
    }
    state.time_s = t;
    told = told_by_encoder(state, faults.encoder_step_m, elapsed_s, told);
    under_way[due] = servo(told);
    due = (due + 1) % under_way.size();
    report = pacer.report();
  }
  return report;
}

}  // namespace beatlas::device
