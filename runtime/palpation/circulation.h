#pragma once
/// The left ventricle between two atria held at a pressure: time-varying elastance, valves that are
/// ideal diodes, a three-element Windkessel, and a finger that pushes on the wall.
///
///   V' = (LAP - P)/R_mv (mitral, when open) - Q,   Q = (P - P_c)/(R_av + Zc) (aortic, when open),
///   C P_c' = Q - (P_c - RAP)/R,   P = Emin (V - V0) + q + p + F/S_c,
///
/// in mmHg, ml, s. The wall is paper B's horizontal muscle around the ventricle. Emin is its spring
/// K_h2. q is the branch of K_h1 and C_h, q' = E_1 V' - lambda q (equation 3 by equation 1). While
/// the muscle contracts, the contractile element takes their place: p = (Emax - Emin) e(t) (V -
/// V0), and q dies away undriven. When it lets go, p decays by equation (2), p' = -lambda p with
/// lambda = K_h1/C_h. So P is continuous, and every row of Table 1 but the vertical ones acts here.
///
/// The finger is fixed in space: it stands D below the wall as that lay at end-diastole, the wall
/// moves by x1 = (V - V_ref)/S_c, and by virtual work the finger's force F adds F/S_c to the
/// pressure. It keeps the ventricle from filling, and the atria's pressure is fixed: that is how
/// the stroke volume falls.
///
/// Integrated by the L-stable two-stage SDIRK method of Alexander (1977): each stage is one
/// increasing, piecewise straight equation for V, solved to rounding, so valves and finger may open
/// and close within a step of any length. A tick in which the flow changes at a blow is parted,
/// down to 32 parts; what is too quick for these is backward Euler's, which never overshoots.
/// Neither allocates nor throws once it is made.

#include <algorithm>

#include "runtime/palpation/elastance.h"

namespace beatlas::palpation {

/// How the finger meets the wall, in the circulation.
enum class Contact {
  Kinematic,    ///< a stop: F = K (D + x1), K = stop_n_per_m
  Viscoelastic  ///< the stop presses on a spring and a damper: paper B's vertical element
};

/// The default is a dog of 25 kg (physiology after Anesthesiology 1996;85:112; atrial pressures and
/// mean aortic pressure as paper B prints them).
struct CirculationParameters {
  /// What the other numbers belong to; at_weight() scales them. That of a body whose healthy
  /// heart is as large: a dilated one is that of a giant.
  double weight_kg = 25;
  static constexpr double kSlowestPerMin = 30;
  static constexpr double kQuickestPerMin = 220;
  double heart_rate_per_min = 110;  ///< within these
  double left_atrial_mmhg = 9;      ///< 0..40
  double right_atrial_mmhg = 7;     ///< 0..40
  double resistance = 2.38;         ///< R [mmHg s/ml]
  double impedance = 0.104;         ///< Zc [mmHg s/ml]
  double compliance = 0.57;         ///< C [ml/mmHg]
  double aortic_valve = 0.008;      ///< R_av [mmHg s/ml]
  double mitral_valve = 0.012;      ///< R_mv [mmHg s/ml]
  double emax = 4.5;                ///< [mmHg/ml] of the healthy muscle
  double emin = 0.19;               ///< [mmHg/ml] <= emax; of the spring K_h2
  /// E_1 [mmHg/ml] of the branch of K_h1 and C_h: to Emin as Table 1's mean K_h1 to its mean K_h2.
  double branch_elastance = 0.19 * (30.1 + 164.8 + 98.9) / (766.5 + 709.6 + 655.4);
  double v0_ml = 5;  ///< where the pressure is 0
  /// lambda of equation (2), P(t) = P(0) exp(-K1 t / C), and of the branch: mean of Table 1's
  /// K_h1 / C_h, 32.4 1/s.
  double relaxation_rate_per_s = (30.1 / 4.6 + 164.8 / 2.1 + 98.9 / 8.2) / 3;
  double contractility = 1;     ///< 0.1..3: times emax
  double infarct_fraction = 0;  ///< 0..1: share f of the muscle that is infarcted
  double infarct_alpha = 0;     ///< 0..1: how much of its contraction is left

  // The finger.
  Contact contact = Contact::Kinematic;
  double contact_area_cm2 = 14.1;  ///< S_c: 8 mm take the cardiac output to 74 %
  double stop_n_per_m = 2e4;
  double finger_k_n_per_m = 75;       ///< viscoelastic: K_v
  double finger_c_n_s_per_m = 60;     ///< viscoelastic: C_v
  double reference_volume_ml = 49.8;  ///< V_ref: end-diastole of the natural beat

  /// Emax that is left: emin + (contractility emax - emin) (1 - f (1 - alpha)).
  [[nodiscard]] double effective_emax() const noexcept;
  /// @throws Error{InvalidInput} naming the first number that is out of range, and the range.
  void check() const;
};

/// The other reading of "decrease in about 74 %": 8 mm lower the cardiac output *by* 74 %. It needs
/// 70 % of the wall's side to give way to one finger.
inline constexpr double kContactAreaFallsBy74Cm2 = 41.3;
/// Viscoelastic contact whose 8 mm take the cardiac output to about 75 %; with a dent that the next
/// beat still finds, that is as far as Table 1 can take it.
inline constexpr double kContactAreaViscoelasticCm2 = 25;

/// The same animal with another weight: resistances go with W^-3/4, compliance and volumes with W,
/// elastances with 1/W, areas with W^2/3. @param weight_kg > 0
[[nodiscard]] CirculationParameters at_weight(const CirculationParameters& parameters,
                                              double weight_kg) noexcept;

/// One beat, from end-diastole to end-diastole.
struct Beat {
  double edv_ml = 0;             ///< largest volume
  double esv_ml = 0;             ///< smallest
  double stroke_ml = 0;          ///< what went through the aortic valve
  double ejection_fraction = 0;  ///< 0..1
  double output_l_per_min = 0;
  double peak_lv_mmhg = 0;
  double aortic_high_mmhg = 0;
  double aortic_low_mmhg = 0;
  double aortic_mean_mmhg = 0;
  double dpdt_max_mmhg_per_s = 0;
  double contracting_ml = 0;  ///< mean volume while the muscle contracts: equation (5)'s integral
};

/// Energy since the start [J]: finger + muscle + atria = dissipated + stored - stored at the start.
struct Ledger {
  double finger_j = 0;      ///< done by the finger's motion
  double muscle_j = 0;      ///< done by the change of elastance, and of parameters
  double atria_j = 0;       ///< brought in from the left atrium, less what is left to the right one
  double dissipated_j = 0;  ///< in valves, vessels and the finger's damper
  double stored_j = 0;      ///< now: in ventricle, Windkessel and finger
  double turned_over_j =
      0;  ///< sum of the sizes of all that flowed: what a residual is held against

  double stored_at_start_j = 0;
  [[nodiscard]] double residual_j() const noexcept {
    return finger_j + muscle_j + atria_j - dissipated_j - (stored_j - stored_at_start_j);
  }
};

class Circulation {
 public:
  /// @throws Error{InvalidInput} as CirculationParameters::check.
  explicit Circulation(const CirculationParameters& parameters);

  /// Other parameters from now on; the heart rate from the next beat on. Trusts them to be in
  /// range.
  void adjust(const CirculationParameters& parameters) noexcept;
  [[nodiscard]] const CirculationParameters& parameters() const noexcept { return p_; }

  /// @param step_s > 0, shorter than a beat; @param depth_m D at its end, from -1 to 1 m. Beyond
  /// where the ventricle would be squeezed to V0 the finger meets the other wall: it is held there.
  void tick(double step_s, double depth_m) noexcept;
  /// Beats on without a finger until the stroke volume is that of the beat before, to 1e-9.
  void settle(double step_s = 1e-3) noexcept;

  [[nodiscard]] double volume_ml() const noexcept { return now_.volume; }
  [[nodiscard]] double lv_mmhg() const noexcept { return lv_mmhg_; }
  [[nodiscard]] double aortic_mmhg() const noexcept { return now_.vessel + p_.impedance * aortic_; }
  [[nodiscard]] double mitral_flow_ml_s() const noexcept { return mitral_; }
  [[nodiscard]] double aortic_flow_ml_s() const noexcept { return aortic_; }
  /// Of the finger on the wall, as the circulation has it [N].
  [[nodiscard]] double finger_n() const noexcept { return finger_n_; }
  /// E(t) of equation (6): Emin + (Emax - Emin) e(t), through the whole beat.
  [[nodiscard]] double elastance_mmhg_per_ml() const noexcept { return elastance_; }
  /// What of the pressure the passive wall carries: not the contraction's p, nor the finger's
  /// share, which is of a stop and not of a fingertip.
  [[nodiscard]] double filling_mmhg() const noexcept {
    return p_.emin * (now_.volume - p_.v0_ml) + now_.branch;
  }
  /// Before the muscle lets go by equation (2).
  [[nodiscard]] bool contracting() const noexcept { return contracting_; }
  [[nodiscard]] double activation() const noexcept { return activation_; }
  /// 0..1 of the beat, 0 at end-diastole.
  [[nodiscard]] double phase() const noexcept { return beat_s_ / curve_.period_s(); }
  [[nodiscard]] long beats() const noexcept { return beats_; }
  [[nodiscard]] const Beat& last_beat() const noexcept { return last_; }
  [[nodiscard]] const Ledger& ledger() const noexcept { return ledger_; }

 private:
  struct State {
    double volume;
    double vessel;  // P_c [mmHg]
    double dent;    // of the finger's spring and damper [m]
    double branch;  // q [mmHg]
  };
  static constexpr double kLeastMl = 1e-6;  // less is no length that could shorten
  struct Stage;
  struct Derived {
    double span;        // Emax_eff - Emin
    double out;         // R_av + Zc
    double x_per_ml;    // m the wall moves a ml
    double mmhg_per_n;  // pressure a newton adds
  };

  void derive() noexcept;
  void advance(double step_s, double depth_rate_m_s, double& flowed_ml) noexcept;
  void let_go() noexcept;
  /// p at a volume, of what is left of it at V_x and above.
  [[nodiscard]] double letting_go(double volume_ml, double left_mmhg) const noexcept {
    const double length = (volume_ml - p_.v0_ml) / std::max(let_go_ml_, kLeastMl);
    return left_mmhg * std::min(1.0, length);
  }
  [[nodiscard]] Stage solve(const State& base, double time_s, double gamma_s, double depth_m,
                            double guess_ml) const noexcept;
  enum class Care {
    Accurate,      ///< in parts small enough for what happens in them
    Sound,         ///< no smaller part is tried, but none may overshoot
    BackwardEuler  ///< of the first order; never beyond where all comes to rest
  };
  [[nodiscard]] bool part(double step_s, double depth_rate_m_s, Care care,
                          double& flowed_ml) noexcept;
  void accept(const Stage& stage, double step_s) noexcept;
  void account(const Stage& stage, double share_s, double depth_rate_m_s) noexcept;
  [[nodiscard]] double stored_j() const noexcept;
  void follow_beat(double step_s, double flowed_ml, double lv_before) noexcept;
  void end_beat() noexcept;

  CirculationParameters p_;
  Derived d_{};
  ElastanceCurve curve_;
  State now_{};
  double depth_m_ = 0;
  double beat_s_ = 0;
  long beats_ = 0;
  double lv_mmhg_ = 0;
  double mitral_ = 0;
  double aortic_ = 0;
  double finger_n_ = 0;
  double elastance_ = 0;
  double activation_ = 0;
  double active_ = 0;      // of the contractile element [mmHg/ml]; 0 once it has let go
  double letting_go_ = 0;  // p since then, at V_x and above [mmHg]
  double let_go_ml_ = 1;   // V_x - V0
  bool contracting_ = true;
  Beat running_;
  Beat last_;
  double running_mean_ = 0;  // integral of the aortic pressure
  double running_s_ = 0;
  double contracting_ml_s_ = 0;  // integral of the volume while the muscle contracts
  double contracting_s_ = 0;
  Ledger ledger_;
};

}  // namespace beatlas::palpation
