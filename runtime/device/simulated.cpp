#include "runtime/device/simulated.h"

#include <cmath>
#include <numbers>

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
  require(options.seconds > 0 && std::isfinite(options.seconds),
          "the simulated device must play for more than 0 seconds");
  options_.path.direction.normalize();
}

RunReport SimulatedDevice::run(const ServoFn& servo, std::stop_token stop) {
  const HandPath& path = options_.path;
  const HandModel& hand = options_.hand;
  Pacer pacer(options_.pace, options_.rate_hz);
  DeviceState state;
  state.position_m = path.position_m(0);
  state.velocity_m_s = path.velocity_m_s(0);
  Vec3 force_n = Vec3::Zero();
  RunReport report;
  const auto ticks = static_cast<std::int64_t>(std::ceil(options_.seconds * options_.rate_hz));
  while (!stop.stop_requested()) {
    const double t = pacer.next();
    if (std::llround(t * options_.rate_hz) >= ticks) break;
    if (hand.mass_kg > 0) {
      const double dt = t - state.time_s;
      const Vec3 target = 0.5 * (path.position_m(t) + path.position_m(state.time_s));
      const Vec3 drift = 0.5 * (path.velocity_m_s(t) + path.velocity_m_s(state.time_s));
      // Velocity and place at the middle of the step: x_m = x + dt/2 v_m.
      const double inertia = 2 * hand.mass_kg;
      const Vec3 impulse = inertia * state.velocity_m_s +
                           dt * (hand.stiffness_n_per_m * (target - state.position_m) +
                                 hand.damping_n_s_per_m * drift + force_n);
      const Vec3 middle = impulse / (inertia + dt * hand.damping_n_s_per_m +
                                     0.5 * dt * dt * hand.stiffness_n_per_m);
      state.position_m += dt * middle;
      state.velocity_m_s = 2 * middle - state.velocity_m_s;
    } else {
      state.position_m = path.position_m(t);
      state.velocity_m_s = path.velocity_m_s(t);
    }
    state.time_s = t;
    force_n = servo(state);
    report = pacer.report();
  }
  return report;
}

}  // namespace beatlas::device
