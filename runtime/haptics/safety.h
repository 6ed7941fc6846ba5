#pragma once
/// The last stage before any device. Force errors are measured before it; it is always on.

#include <array>
#include <cstdint>

#include "runtime/base/geometry.h"

namespace beatlas::haptics {

struct SafetyOptions {
  double peak_n = 3;          ///< [N] 0.05..40: largest force
  double slew_n_per_s = 50;   ///< [N/s] 1..5000: largest change of force, except to zero on a fault
  double max_depth_mm = 15;   ///< [mm] 0.1..100: deeper, the force stays that of this depth
  double start_ramp_s = 0.5;  ///< [s] 0..10: rise from no force at the start and after a fault
  double max_gap_s = 0.01;    ///< [s] 0.001..1: a longer gap between two ticks is a fault
};

enum class TickStatus : std::uint8_t {
  Ok,       ///< the force is the model's
  Limited,  ///< peak, slew, depth or start ramp made it smaller
  Fault,    ///< the force is zero: an invalid state, no number, time not going on, or stopped
};

struct SafeForce {
  Vec3 force_n = Vec3::Zero();
  TickStatus status = TickStatus::Fault;
};

/// Keeps the force before; one per device, called from its servo thread.
class SafetyStage {
 public:
  /// @throws Error{InvalidInput} if an option is out of range.
  explicit SafetyStage(const SafetyOptions& options);

  /// @param wanted_n the model's force, proportional to its depth_mm; time_s of the tick;
  /// `valid` false if the device says that its state cannot be trusted.
  /// A fault gives zero at once and the next good tick starts the ramp again.
  /// One tick may repeat the time of the one before, as under a clock that counts whole
  /// milliseconds: no time, no change, so the force stays. The next that does is a fault, as every
  /// one after it until time goes on: else a clock that stands would hold a force for good.
  [[nodiscard]] SafeForce apply(const Vec3& wanted_n, double depth_mm, double time_s,
                                bool valid) noexcept;

  /// Zero force from now on, until `restart`.
  void stop() noexcept { stopped_ = true; }
  void restart() noexcept;

  /// All it remembers from tick to tick.
  using Memory = std::array<double, 7>;
  [[nodiscard]] Memory memory() const noexcept;
  void restore(const Memory& memory) noexcept;

 private:
  enum class State : std::uint8_t {
    Off,       // before the first good tick, and after a fault
    Running,   // time went on
    Repeated,  // the last tick had the time of the one before it
    Stands,    // after the fault of a clock that stands still
  };

  SafetyOptions options_;
  Vec3 last_n_ = Vec3::Zero();
  double last_time_s_ = 0;
  double start_time_s_ = 0;
  State state_ = State::Off;
  bool stopped_ = false;
};

/// The same for a torque, where a tool has one: scaled as the safety stage scaled the force, never
/// made larger, and changed by at most the force's largest change at the tool's arm. Zero at once
/// where the force is, on a fault, and in the first tick after one. One per tool, called from its
/// servo thread.
class TorqueStage {
 public:
  /// @param arm_mm from the tool's centre to its farthest point
  TorqueStage(double slew_n_per_s, double arm_mm) noexcept
      : slew_n_mm_per_s_(slew_n_per_s * arm_mm) {}

  /// @param torque_n_mm, model_n what the model said  @param safe what the safety stage made of it
  [[nodiscard]] Vec3 apply(const Vec3& torque_n_mm, const Vec3& model_n, const SafeForce& safe,
                           double time_s) noexcept;

 private:
  double slew_n_mm_per_s_;
  Vec3 last_n_mm_ = Vec3::Zero();
  double last_time_s_ = 0;
  bool running_ = false;  // false before the first good tick and after a fault
};

}  // namespace beatlas::haptics
