#pragma once
/// Paper B's constants of muscle from recordings: the horizontal element from a relaxation
/// (equations 2 to 4), the vertical one from a press that is let go.

#include <vector>

namespace beatlas::identify {

/// A value with where 95 of 100 recordings like it would have the true one (profile likelihood of
/// white noise on the force or dent). `open`: the recording does not bound it on that side.
struct Estimate {
  double value = 0;
  double low = 0;
  double high = 0;
  bool open_low = false;
  bool open_high = false;
};

/// Samples at rising times, at least 20; straight between them.
struct Recording {
  std::vector<double> time_s;
  std::vector<double> position_m;  ///< stretch of the muscle, or dent under the finger
  std::vector<double> force_n;     ///< that the muscle pulls with when stretched; on the finger

  /// @throws Error{InvalidInput} if lengths differ, times do not rise, a number is none or nothing
  /// moves.
  void check() const;
};

struct HorizontalFit {
  Estimate k_h1_n_per_m;
  Estimate k_h2_n_per_m;
  Estimate c_h_n_s_per_m;
  double asymptote_n = 0;        ///< kept free: what the force tends to without stretch
  double rms_n = 0;              ///< of what is left
  std::vector<double> fitted_n;  ///< at the samples
};

/// force = k_h2 x + k_h1 (g * x') + A exp(-lambda t) + asymptote, g = exp(-lambda t), lambda = k_h1
/// / c_h: for every lambda from 1 to 300 1/s a linear least squares fit, the best lambda wins.
/// @throws Error{InvalidInput} as Recording::check, and if no positive constants fit.
[[nodiscard]] HorizontalFit identify_horizontal(const Recording& relaxation);

struct VerticalFit {
  Estimate k_v_n_per_m;
  Estimate c_v_n_s_per_m;
  double rms_m = 0;
  std::vector<double> fitted_m;  ///< the dent at the samples
};

/// c_v y' + k_v y = force, the dent as the answer to the recorded force, for every k_v / c_v from
/// 0.05 to 100 1/s. The wall's mass is below what a recording shows.
/// @throws Error{InvalidInput} as identify_horizontal.
[[nodiscard]] VerticalFit identify_vertical(const Recording& press);

}  // namespace beatlas::identify
