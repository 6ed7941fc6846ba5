#pragma once
#include "runtime/device/device.h"
#include "runtime/device/pacer.h"

namespace beatlas::device {

/// Where the hand wants to be: x(t) = anchor + direction (offset + amplitude sin(2 pi f t)).
/// Amplitude 0 is a still hand; else palpation.
struct HandPath {
  Vec3 anchor_m = Vec3::Zero();
  Vec3 direction = Vec3::UnitX();  ///< any length but 0
  double offset_m = 0;
  double amplitude_m = 0;   ///< [m] >= 0
  double frequency_hz = 0;  ///< [1/s] >= 0

  [[nodiscard]] Vec3 position_m(double t) const;
  [[nodiscard]] Vec3 velocity_m_s(double t) const;
};

/// A hand and stylus of mass m that a spring and a damper pull to the path and the rendered force
/// pushes: m x'' = k (p - x) + c (p' - x') + F. Implicit midpoint rule: second order, and stable
/// for any m, k, c and rate. Mass 0: the point is on the path, whatever the force.
struct HandModel {
  double mass_kg = 0;              ///< [kg] 0 or 0.001..10
  double stiffness_n_per_m = 300;  ///< [N/m] >= 0
  double damping_n_s_per_m = 5;    ///< [N s/m] >= 0
};

/// What a real device does to positions and forces; all 0: nothing.
struct DeviceFaults {
  double viscous_n_s_per_m = 0;  ///< [N s/m] >= 0: of the mechanism, against the frame
  double coulomb_n = 0;          ///< [N] >= 0: dry friction of the mechanism; it sticks
  double encoder_step_m = 0;     ///< [m] >= 0: positions are told in whole steps; velocities, as
                                 ///< drivers do, by the difference of two positions told
  int delay_ticks = 0;           ///< 0..100: until a force acts, beside the tick that holds it
};

struct SimulatedOptions {
  HandPath path;
  HandModel hand;
  DeviceFaults faults;    ///< friction and delay act on a hand with a mass
  double seconds = 1;     ///< [s] > 0
  double rate_hz = 1000;  ///< [1/s]
  Pace pace = Pace::RealTime;
};

/// A device without hardware; what tests use.
class SimulatedDevice final : public Device {
 public:
  /// @throws Error{InvalidInput} if an option is out of range.
  explicit SimulatedDevice(const SimulatedOptions& options);

  [[nodiscard]] std::string name() const override { return "simulated"; }
  RunReport run(const ServoFn& servo, std::stop_token stop) override;

 private:
  SimulatedOptions options_;
};

}  // namespace beatlas::device
