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
  SafetyOptions options_;
  Vec3 last_n_ = Vec3::Zero();
  double last_time_s_ = 0;
  double start_time_s_ = 0;
  bool running_ = false;  // false before the first good tick and after a fault
  bool stopped_ = false;
};

}  // namespace beatlas::haptics
