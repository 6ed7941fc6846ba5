#pragma once
/// The exact solution of m y'' + c y' + k y = f over a step in which f is a straight line: the
/// 2 x 2 matrix exponential under first-order hold, written so that it keeps its digits from a mass
/// of nothing to a heavy one (paper B's middle patch has poles at -1.25 and -5.2e4 1/s).

namespace beatlas::palpation {

/// SI units. Either `mass_kg` or `damping_n_s_per_m` must be positive, none negative.
struct LinearOscillator {
  double mass_kg = 0;
  double damping_n_s_per_m = 0;
  double stiffness_n_per_m = 0;
};

struct Motion {
  double place_m = 0;
  double speed_m_s = 0;
};

/// What a step of one length does; linear in the state and in the force at its ends.
class OscillatorStep {
 public:
  OscillatorStep() = default;
  /// @param step_s >= 0
  OscillatorStep(const LinearOscillator& oscillator, double step_s) noexcept;

  /// @param force_n at the start; @param force_rate_n_s its slope over the step
  [[nodiscard]] Motion advance(const Motion& from, double force_n,
                               double force_rate_n_s) const noexcept;

 private:
  double y_y_ = 1, y_v_ = 0, y_f_ = 0, y_r_ = 0;  // new place from place, speed, force, its slope
  double v_y_ = 0, v_v_ = 1, v_f_ = 0, v_r_ = 0;  // new speed
};

/// (exp(z) - 1) / z and (exp(z) - 1 - z) / z^2, at full precision around 0.
[[nodiscard]] double phi1(double z) noexcept;
[[nodiscard]] double phi2(double z) noexcept;

}  // namespace beatlas::palpation
