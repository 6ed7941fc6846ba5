#pragma once
/// The heart's own time. Its rate follows what is wished smoothly, so neither the phase nor the
/// rate jumps: a surface in contact moves on without a step.

#include <array>
#include <optional>

namespace beatlas::haptics {

struct HeartOptions {
  /// [1/min] 10..300: heart rate; none: that of the atlas
  std::optional<double> rate_per_min = std::nullopt;
  /// [s] 0.02..10: time constant with which the rate follows, in pauses too
  double settling_s = 0.25;
};

/// What the heart is wished to do; taken up at the next tick.
struct HeartWish {
  double rate_hz = 1;  ///< beats a second
  bool paused = false;
  /// 0..1, or below 0 for none: beat on to this phase of the cycle and stay there.
  double hold_phase = -1;
};

/// Phase by the exact solution of rate' = (wish - rate) / settling_s over each tick.
///
/// A hold beats on until it is as far ahead of the phase as a pause would roll, then rolls out onto
/// it exactly; the way left falls by exp(-dt / settling_s) a tick.
class HeartClock {
 public:
  static constexpr double kSlowestHz = 10.0 / 60;
  static constexpr double kFastestHz = 300.0 / 60;

  /// @param period_s of the atlas [s] > 0.
  /// @throws Error{InvalidInput} if an option is out of range.
  HeartClock(double period_s, const HeartOptions& options);

  /// Goes on by `elapsed_s` >= 0 towards `wish`; a rate is kept within the limits above, or
  /// the first one.
  void advance(double elapsed_s, const HeartWish& wish) noexcept;
  /// Another atlas: the phase of the cycle stays.
  void set_period(double period_s) noexcept { period_s_ = period_s; }

  /// Beats since the start; goes on without a wrap.
  [[nodiscard]] double beats() const noexcept { return beats_; }
  /// 0..1
  [[nodiscard]] double phase() const noexcept;
  [[nodiscard]] double rate_hz() const noexcept { return rate_hz_; }
  /// [s] where the field of the atlas is asked.
  [[nodiscard]] double field_time_s() const noexcept { return beats_ * period_s_; }
  /// d field time / d time.
  [[nodiscard]] double speed() const noexcept { return rate_hz_ * period_s_; }
  /// What an atlas and the options wish before anybody else does.
  [[nodiscard]] const HeartWish& first_wish() const noexcept { return first_wish_; }

  using Memory = std::array<double, 3>;
  [[nodiscard]] Memory memory() const noexcept { return {beats_, rate_hz_, landing_}; }
  void restore(const Memory& memory) noexcept;

 private:
  double period_s_;
  double settling_s_;
  HeartWish first_wish_;
  double beats_ = 0;
  double rate_hz_;
  double landing_ = -1;  // the beat onto which a hold rolls out, below 0 while there is none
};

}  // namespace beatlas::haptics
