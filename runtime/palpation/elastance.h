#pragma once
/// How far a ventricle is contracted over a beat.

namespace beatlas::palpation {

/// e(t) of a time-varying elastance E = Emin + (Emax - Emin) e(t), t from end-diastole:
/// Stergiopulos et al. 1996, e = h1 h2, h1 = g1/(1+g1), h2 = 1/(1+g2), g1 = (t/0.303T)^1.32,
/// g2 = (t/0.508T)^21.9; from the first t > 0.2 T at which its logarithm falls as fast as the
/// relaxation rate it decays by that rate (paper B, equation 2), smoothly joined; the straight line
/// from 0 to its value at T is taken off, so that it closes; scaled to a maximum of 1.
class ElastanceCurve {
 public:
  /// @param period_s of a beat > 0; @param relaxation_rate_per_s > 0. Takes a microsecond.
  ElastanceCurve(double period_s, double relaxation_rate_per_s) noexcept;

  struct Sample {
    double value = 0;  ///< 0..1
    double slope_per_s = 0;
  };
  /// @param time_s 0..period
  [[nodiscard]] Sample at(double time_s) const noexcept;

  [[nodiscard]] double period_s() const noexcept { return period_s_; }
  [[nodiscard]] double rate_per_s() const noexcept { return rate_per_s_; }
  /// Where the decay by the relaxation rate begins [s]; the period if it never does.
  [[nodiscard]] double relaxes_from_s() const noexcept { return joint_ * period_s_; }

 private:
  double period_s_;
  double rate_per_s_;
  double joint_ = 1;        // of the period
  double joint_value_ = 0;  // before scaling
  double end_value_ = 0;
  double scale_ = 1;
};

}  // namespace beatlas::palpation
