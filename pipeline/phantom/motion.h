#pragma once
#include <string>

namespace beatlas::phantom {

/// The phantom's clock: s, the share of the stroke volume that has left the heart, 0 at end
/// diastole and 1 at end systole. Periodic and C2.
///
/// In a cycle of 0.75 s (other R-R intervals stretch all of it)
///   ds/dt = ejection - 0.75 * early filling - 0.25 * atrial filling,
///   pulse(t0, d, k) = (1 - cos 2 pi u) / area,  u = ((t - t0) / d)^k in [0, 1],
/// with ejection pulse(0.050, 0.280, 0.80), early filling pulse(0.400, 0.160, 0.85) and atrial
/// filling pulse(0.615, 0.115, 1); times in seconds. Integrated in closed form as a power series.
/// @param t_s any time [s]; @param rr_interval_s > 0
[[nodiscard]] double volume_loss(double t_s, double rr_interval_s);

/// d volume_loss / dt [1/s].
[[nodiscard]] double volume_loss_rate(double t_s, double rr_interval_s);

/// The definition above as one sentence, for the truth file.
[[nodiscard]] std::string volume_loss_description();

}  // namespace beatlas::phantom
