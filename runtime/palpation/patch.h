#pragma once
/// The wall under one finger: paper B's vertical mass, spring and damper.
///
/// As printed (`kelvin_voigt`) m y'' + C_v y' + K y = F, y the dent. To be touched with a device
/// (`standard_linear_solid`) the finger reaches it through a spring in series,
///
///   F = K_c (d - y) >= 0,   m y'' + C y' + K_s y = F,   K_s = K K_c / (K_c - K),
///   C = C_v K_s / K,
///
/// d the finger's depth: pressed for long it is as stiff as printed (K), let go it recovers as
/// printed (C_v / K), and in contact its time constant is C_v / K_c. No speed of a device is ever
/// multiplied by C_v: with that, a real encoder makes the force chatter by newtons. K may change
/// from step to step, as it does by equation (6).

#include <cstdint>

#include "runtime/palpation/oscillator.h"

namespace beatlas::palpation {

struct VerticalConstants {
  double mass_kg = 1.14e-3;       ///< >= 0: rho S h of 1.2 cm^2 of a 9 mm wall; paper B prints none
  double damping_n_s_per_m = 60;  ///< > 0: C_v
  double contact_n_per_m = 800;   ///< K_c: an encoder of 55 um then steps by 0.044 N, below 5 gf
};

/// `standard_linear_solid`, exact: depth is a straight line over a step, and where finger and wall
/// meet or part within it is found, so steps of any length give the same samples.
class VerticalPatch {
 public:
  static constexpr double kStiffestShare = 0.95;  ///< of K_c that K may be

  /// @throws Error{InvalidInput} if a constant is negative or no number, or mass and damping are 0.
  explicit VerticalPatch(const VerticalConstants& constants);

  /// @param depth_m of the finger at the end of the step, below the undented wall; negative: above
  /// @param stiffness_n_per_m K over this step, 0 .. kStiffestShare K_c (held there)
  /// @return F on the finger [N], >= 0
  double advance(double depth_m, double stiffness_n_per_m, double step_s) noexcept;

  /// C_v from the next step on; the finger has slid to another place. > 0
  void set_damping(double damping_n_s_per_m) noexcept;

  [[nodiscard]] double dent_m() const noexcept { return wall_.place_m; }
  [[nodiscard]] double force_n() const noexcept;
  [[nodiscard]] bool touching() const noexcept { return touching_; }
  /// Held in mass and both springs [J].
  [[nodiscard]] double energy_j() const noexcept;

  struct State {
    Motion wall;
    double depth_m = 0;
    double stiffness_n_per_m = 0;
    bool touching = false;
  };
  [[nodiscard]] State state() const noexcept;
  void restore(const State& state) noexcept;

 private:
  struct Line;  // the finger's way over what is left of a step
  void set_stiffness(double stiffness_n_per_m) noexcept;
  void derive() noexcept;
  [[nodiscard]] OscillatorStep step_of(double step_s) noexcept;
  [[nodiscard]] Motion moved(const Line& line, double step_s) noexcept;
  [[nodiscard]] double gap_m(const Line& line, double step_s) noexcept;
  [[nodiscard]] bool parts_within(const Line& line, double step_s, double& at_s) noexcept;

  double mass_kg_;
  double printed_damping_;
  double contact_;
  double stiffness_ = -1;  // K
  double spring_ = 0;      // K_s
  double damping_ = 0;     // C
  Motion wall_;
  double depth_m_ = 0;
  bool touching_ = false;
  // The step used last, in and out of contact: ticks are mostly of one length.
  OscillatorStep kept_[2];
  double kept_step_s_[2] = {-1, -1};
};

/// `kelvin_voigt`, exact: pushed with a force that is a straight line over each step.
class KelvinVoigtPatch {
 public:
  /// @throws Error{InvalidInput} as VerticalPatch.
  KelvinVoigtPatch(double mass_kg, double damping_n_s_per_m, double stiffness_n_per_m);

  /// @param force_n on the wall at the end of the step. @return dent [m]
  double push(double force_n, double step_s) noexcept;
  [[nodiscard]] const Motion& wall() const noexcept { return wall_; }
  [[nodiscard]] double energy_j() const noexcept;

  /// Force [N] that a path in closed form asks for; for offline work alone, never with a device's
  /// speed. A finger cannot pull: >= 0.
  [[nodiscard]] double reaction_n(double dent_m, double speed_m_s,
                                  double acceleration_m_s2) const noexcept;

 private:
  LinearOscillator oscillator_;
  Motion wall_;
  double force_n_ = 0;
  OscillatorStep kept_;
  double kept_step_s_ = -1;
};

}  // namespace beatlas::palpation
