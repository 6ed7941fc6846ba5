#pragma once
/// The muscle of paper B (Tokuyasu et al., FIMH 2003): what Table 1 prints, blended along the long
/// axis, and what scar and wall thickness do to it.

#include <array>

namespace beatlas::palpation {

/// Of one place of the wall. Horizontal: k_h1 in series with c_h, k_h2 beside both; vertical: a
/// spring and a damper side by side under the finger.
struct MuscleConstants {
  double k_h1_n_per_m = 0;
  double k_h2_n_per_m = 0;
  double c_h_n_s_per_m = 0;
  double k_v_n_per_m = 0;
  double c_v_n_s_per_m = 0;

  [[nodiscard]] bool operator==(const MuscleConstants&) const = default;
};

/// Table 1 of paper B as printed.
struct MuscleTable {
  MuscleConstants base{30.1, 766.5, 4.6, 90, 72};
  MuscleConstants middle{164.8, 709.6, 2.1, 75, 60};
  MuscleConstants apex{98.9, 655.4, 8.2, 45, 51};

  /// Mean of k_h1 / c_h [1/s]: the rate of equation (2), P(t) = P(0) exp(-K1 t / C), of the whole
  /// ventricle; 32.4 1/s for Table 1.
  [[nodiscard]] double relaxation_rate_per_s() const noexcept;
  /// Means of base, middle and apex [N/m]: a cylinder's wall gives way as a whole, so the three
  /// lie side by side.
  [[nodiscard]] double mean_k_h1_n_per_m() const noexcept;
  [[nodiscard]] double mean_k_h2_n_per_m() const noexcept;
};

/// The table at a place of the long axis: apex at 1/6, middle at 1/2, base at 5/6, between them
/// straight in the logarithm of each constant, beyond them constant.
/// @param long_axis 0 apex .. 1 base. @pre all constants are positive
[[nodiscard]] MuscleConstants blend(const MuscleTable& table, double long_axis) noexcept;

/// What disease made of a place.
struct Tissue {
  double scar = 0;             ///< 0..1: share of scar in the wall
  double thickness_ratio = 1;  ///< 0.3..2: thickness over that of the healthy wall
  double alpha = 1;            ///< 0..1: how much of the contraction is left; paper B's alpha
  double stiffness_ratio = 1;  ///< 0.1..10: of the muscle itself over healthy muscle at rest

  [[nodiscard]] bool operator==(const Tissue&) const = default;
};

inline constexpr double kScarStiffening = 0.53;  ///< 4.6 over 3.0 kPa, less 1 (PMC5628104)

inline constexpr double kSoftestRatio = 0.1;  ///< of Tissue::stiffness_ratio
inline constexpr double kStiffestRatio = 10;

/// Scar is stiffer by 0.53 of its share (elastography of pigs, PMC5628104), but a plate bends by
/// the square of its thickness: k_v (1 + 0.53 g) (h/h0)^2 and k_h2 (1 + 0.53 g) h/h0, both times
/// the ratio of stiffness; c_v keeps the time c_v / k_v in which the dent recovers.
[[nodiscard]] MuscleConstants in_tissue(const MuscleConstants& healthy,
                                        const Tissue& tissue) noexcept;

/// The ventricle as the cylinder of Fig. 5, whose length is 1.6 times its diameter (a choice: the
/// paper prints neither).
struct Cylinder {
  double diameter_cm = 0;
  double length_cm = 0;

  /// Its side [cm^2]: S0 of equation (1), V' = S0 x1'; 58.6 for 50 ml.
  [[nodiscard]] double side_area_cm2() const noexcept;
};
[[nodiscard]] Cylinder cylinder_of(double volume_ml) noexcept;

/// Equation (5), S_n = (1/T_s) integral(V_e / L_0) dt [cm^2]: the mean section of the cylinder
/// while it contracts. Read so: T_s is the time from end-diastole until the muscle lets go, V_e the
/// ventricle's volume, L_0 the cylinder's length at end-diastole.
/// @param contracting_ml mean of V_e over T_s  @param reference_ml at end-diastole
[[nodiscard]] double shortening_area_cm2(double contracting_ml, double reference_ml) noexcept;

/// Equation (6), K_e = alpha S_n S E(t), of the contractile element.
struct Contractile {
  double shortening_area_cm2 = 0;  ///< S_n; 0: of the beat, by equation (5)
  /// S: what the fingertip touches, which is less than S_c, the wall that its dent takes along. So
  /// chosen that in systole the wall is 1.71 times as stiff under it as in diastole, the ratio of
  /// the canine tactile stiffnesses 2.20 and 1.29 g/mm^2 (Miyaji 2000).
  double finger_area_cm2 = 3.0;

  /// [N/m]  @param beat_area_cm2 S_n by equation (5)
  [[nodiscard]] double stiffness_n_per_m(double alpha, double beat_area_cm2,
                                         double elastance_mmhg_per_ml) const noexcept;
};

/// What a pressure in a thin-walled ventricle adds to the stiffness under a finger, pi p R [N/m]: a
/// dent must turn the wall's tension, p R, inwards. R is the cylinder's radius at end-diastole.
/// @param filling_mmhg what the passive wall carries; that of the contraction is in K_e
[[nodiscard]] double pressure_n_per_m(double filling_mmhg, double reference_ml) noexcept;

/// Horizontal three-element muscle (equation 3): f = -k_h2 x - q, q the force in the branch of k_h1
/// and c_h, q' = k_h1 x' - (k_h1 / c_h) q. Equation (3) prints the branch's force as that of its
/// damper; in a branch in series it is also that of its spring. While the muscle contracts, spring
/// and damper are replaced by the contractile element: q = K_e x.
class HorizontalMuscle {
 public:
  HorizontalMuscle(double k_h1_n_per_m, double k_h2_n_per_m, double c_h_n_s_per_m) noexcept;

  /// Other constants from now on; stretch and the branch's force stay.
  void set(double k_h1_n_per_m, double k_h2_n_per_m, double c_h_n_s_per_m) noexcept;

  /// Stretched along a straight line to `stretch_m` in `step_s`; exact for steps of any length.
  /// @return f [N]
  double relax(double stretch_m, double step_s) noexcept;
  /// The contractile element holds the branch at this stretch. @return f [N]
  double contract(double stretch_m, double contractile_n_per_m) noexcept;

  [[nodiscard]] double branch_n() const noexcept { return branch_n_; }
  [[nodiscard]] double force_n() const noexcept { return -k2_ * stretch_m_ - branch_n_; }
  /// Held in both springs [J].
  [[nodiscard]] double energy_j() const noexcept;

 private:
  double k1_;
  double k2_;
  double rate_per_s_;
  double stretch_m_ = 0;
  double branch_n_ = 0;
};

}  // namespace beatlas::palpation
