#include "pipeline/phantom/motion.h"

#include <cmath>
#include <numbers>

namespace beatlas::phantom {
namespace {

constexpr double kCycleS = 0.75;

struct Pulse {
  double start_s;
  double length_s;
  double power;
};
constexpr Pulse kEjection{0.050, 0.280, 0.80};
constexpr Pulse kEarly{0.400, 0.160, 0.85};
constexpr Pulse kAtrial{0.615, 0.115, 1.0};
constexpr double kEarlyShare = 0.75;

/// Integral over [0, x] of 1 - cos(2 pi y^k): the cosine's series, term by term. x in [0, 1].
double pulse_area(double x, double k) {
  double sum = 0.0;
  double term = -1.0;
  for (int m = 1; m <= 30; ++m) {
    term *= -std::pow(2.0 * std::numbers::pi, 2) / ((2.0 * m - 1.0) * (2.0 * m));
    sum += term * std::pow(x, 2.0 * m * k + 1.0) / (2.0 * m * k + 1.0);
  }
  return sum;
}

/// Share of the pulse that lies before t_s: 0 before its start, 1 after its end.
double share(const Pulse& pulse, double t_s) {
  const double x = (t_s - pulse.start_s) / pulse.length_s;
  if (x <= 0.0) return 0.0;
  if (x >= 1.0) return 1.0;
  return pulse_area(x, pulse.power) / pulse_area(1.0, pulse.power);
}

/// Height of the pulse [1/s].
double height(const Pulse& pulse, double t_s) {
  const double x = (t_s - pulse.start_s) / pulse.length_s;
  if (x <= 0.0 || x >= 1.0) return 0.0;
  return (1.0 - std::cos(2.0 * std::numbers::pi * std::pow(x, pulse.power))) /
         (pulse_area(1.0, pulse.power) * pulse.length_s);
}

/// The moment of a cycle of kCycleS.
double cycle_time_s(double t_s, double rr_interval_s) {
  const double cycles = t_s / rr_interval_s;
  return (cycles - std::floor(cycles)) * kCycleS;
}

}  // namespace

double volume_loss(double t_s, double rr_interval_s) {
  const double t = cycle_time_s(t_s, rr_interval_s);
  return share(kEjection, t) - kEarlyShare * share(kEarly, t) -
         (1.0 - kEarlyShare) * share(kAtrial, t);
}

double volume_loss_rate(double t_s, double rr_interval_s) {
  const double t = cycle_time_s(t_s, rr_interval_s);
  return (height(kEjection, t) - kEarlyShare * height(kEarly, t) -
          (1.0 - kEarlyShare) * height(kAtrial, t)) *
         kCycleS / rr_interval_s;
}

std::string volume_loss_description() {
  return "s, share of the stroke volume that has left, 0 at end diastole, 1 at end systole; in a "
         "cycle of 0.75 s (any R-R interval stretches it) ds/dt = P(0.050, 0.280, 0.80) - 0.75 "
         "P(0.400, 0.160, 0.85) - 0.25 P(0.615, 0.115, 1), P(t0, d, k) = 1 - cos(2 pi u) scaled to "
         "unit area, u = ((t - t0) / d)^k in [0, 1]; every length of the anatomy is interpolated "
         "linearly in s but the LV wall, which follows from its constant volume";
}

}  // namespace beatlas::phantom
