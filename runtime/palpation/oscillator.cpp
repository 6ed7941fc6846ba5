#include "runtime/palpation/oscillator.h"

#include <algorithm>
#include <cmath>

namespace beatlas::palpation {
namespace {

// Divided differences of exp(h s) at the nodes {s1, s2}, {0, s1, s2} and {0, 0, s1, s2}, where s1
// and s2 are the poles: g, its integral and the integral of that.
struct Impulse {
  double g = 0;
  double g1 = 0;
  double g2 = 0;
  double released = 1;  // g' + c/m g: what is left of a place let go at rest
  double slowing = 1;   // g': what is left of a speed
};

// Poles times h within this: a Taylor series of complete symmetric polynomials, no cancellation.
constexpr double kSeries = 0.5;

Impulse by_series(double sum, double product, double h) noexcept {
  Impulse out;
  const double p = sum * h;
  const double q = product * h * h;
  double last = 0;
  double now = 1;        // H_0
  double inverse_1 = 1;  // 1 / (j + 1)!
  double g = 0;
  double g1 = 0;
  double g2 = 0;
  for (int j = 0; j < 20; ++j) {
    const double inverse_2 = inverse_1 / (j + 2);
    g += now * inverse_1;
    g1 += now * inverse_2;
    g2 += now * inverse_2 / (j + 3);
    const double next = p * now - q * last;
    last = now;
    now = next;
    inverse_1 = inverse_2;
  }
  out.g = h * g;
  out.g1 = h * h * g1;
  out.g2 = h * h * h * g2;
  out.released = 1 - product * out.g1;
  out.slowing = out.released + sum * out.g;
  return out;
}

Impulse by_real_poles(double fast, double slow, double h) noexcept {
  Impulse out;
  const double left = std::exp(slow * h);
  out.g = h * left * phi1((fast - slow) * h);
  out.g1 = (h * phi1(slow * h) - out.g) / -fast;
  out.g2 = (h * h * phi2(slow * h) - out.g1) / -fast;
  out.released = left - slow * out.g;
  out.slowing = std::exp(fast * h) + slow * out.g;
  return out;
}

Impulse by_complex_poles(double sum, double product, double h) noexcept {
  Impulse out;
  const double sigma = 0.5 * sum;
  const double omega = std::sqrt(product - sigma * sigma);
  const double left = std::exp(sigma * h);
  const double sine = std::sin(omega * h) / omega;
  out.g = left * sine;
  out.slowing = left * (std::cos(omega * h) + sigma * sine);
  out.released = left * (std::cos(omega * h) - sigma * sine);
  out.g1 = (1 - out.released) / product;
  out.g2 = (h - out.g + sum * out.g1) / product;
  return out;
}

}  // namespace

double phi1(double z) noexcept { return z == 0 ? 1 : std::expm1(z) / z; }

double phi2(double z) noexcept {
  if (std::abs(z) > kSeries) return (std::expm1(z) - z) / (z * z);
  double term = 0.5;
  double sum = 0;
  for (int j = 0; j < 16; ++j) {
    sum += term;
    term *= z / (j + 3);
  }
  return sum;
}

OscillatorStep::OscillatorStep(const LinearOscillator& oscillator, double h) noexcept {
  const double m = oscillator.mass_kg;
  const double c = oscillator.damping_n_s_per_m;
  const double k = oscillator.stiffness_n_per_m;
  if (!(m > 0)) {  // c y' + k y = f; a speed is not remembered
    const double z = -k / c * h;
    y_y_ = std::exp(z);
    y_v_ = 0;
    y_f_ = h * phi1(z) / c;
    y_r_ = h * h * phi2(z) / c;
    v_y_ = -k / c * y_y_;
    v_v_ = 0;
    v_f_ = y_y_ / c;
    v_r_ = h * phi1(z) / c;
    return;
  }
  const double discriminant = c * c - 4 * k * m;
  const double sum = -c / m;
  const double product = k / m;
  const double fast = -(c + std::sqrt(std::max(0.0, discriminant))) / (2 * m);
  const double largest = discriminant > 0 ? -fast : std::sqrt(product);
  Impulse impulse;
  if (largest * h <= kSeries) {
    impulse = by_series(sum, product, h);
  } else if (discriminant >= 0) {
    impulse = by_real_poles(fast, product / fast, h);
  } else {
    impulse = by_complex_poles(sum, product, h);
  }
  y_y_ = impulse.released;
  y_v_ = impulse.g;
  y_f_ = impulse.g1 / m;
  y_r_ = impulse.g2 / m;
  v_y_ = -product * impulse.g;
  v_v_ = impulse.slowing;
  v_f_ = impulse.g / m;
  v_r_ = impulse.g1 / m;
}

Motion OscillatorStep::advance(const Motion& from, double force_n,
                               double force_rate_n_s) const noexcept {
  return {y_y_ * from.place_m + y_v_ * from.speed_m_s + y_f_ * force_n + y_r_ * force_rate_n_s,
          v_y_ * from.place_m + v_v_ * from.speed_m_s + v_f_ * force_n + v_r_ * force_rate_n_s};
}

}  // namespace beatlas::palpation
