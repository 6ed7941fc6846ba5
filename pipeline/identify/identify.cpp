#include "pipeline/identify/identify.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <Eigen/Dense>

#include "runtime/base/error.h"
#include "runtime/palpation/oscillator.h"

namespace beatlas::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using palpation::phi1;
using palpation::phi2;

constexpr std::size_t kFewestSamples = 20;
constexpr int kGrid = 240;  // rates tried first, even in the logarithm
constexpr int kHalvings = 60;
constexpr int kProfile = 80;  // rates within the interval
constexpr double kChiSquare95 = 3.841;

// A linear least squares fit at one rate.
struct Linear {
  double rate = 0;
  VectorXd coefficients;
  VectorXd spread;  // diagonal of (X'X)^-1
  double squares = 0;
};

using Design = std::function<MatrixXd(double rate)>;

struct Profile {
  Linear best;
  std::vector<Linear> within;  // rates that the recording allows, rising
  bool open_low = false;
  bool open_high = false;
  double allowed = 0;  // sum of squares above the best's
};

Linear fit_at(const Design& design, const VectorXd& measured, double rate) {
  const MatrixXd x = design(rate);
  Linear out;
  out.rate = rate;
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(x);
  out.coefficients = qr.solve(measured);
  out.squares = (measured - x * out.coefficients).squaredNorm();
  const MatrixXd normal = x.transpose() * x;
  out.spread = normal.ldlt().solve(MatrixXd::Identity(x.cols(), x.cols())).diagonal();
  return out;
}

// The best rate, and those around it that a likelihood ratio does not turn away.
Profile profile(const Design& design, const VectorXd& measured, double lowest, double highest) {
  const auto rate_at = [&](double share) { return lowest * std::pow(highest / lowest, share); };
  const auto squares = [&](double share) {
    return fit_at(design, measured, rate_at(share)).squares;
  };
  int best = 0;
  double least = INFINITY;
  for (int n = 0; n <= kGrid; ++n) {
    const double now = squares(static_cast<double>(n) / kGrid);
    if (now < least) {
      least = now;
      best = n;
    }
  }
  double low = std::max(0.0, (best - 1.0) / kGrid);
  double high = std::min(1.0, (best + 1.0) / kGrid);
  const double golden = 0.5 * (std::sqrt(5.0) - 1);
  for (int i = 0; i < kHalvings; ++i) {
    const double left = high - golden * (high - low);
    const double right = low + golden * (high - low);
    if (squares(left) < squares(right)) {
      high = right;
    } else {
      low = left;
    }
  }
  const double middle = 0.5 * (low + high);
  Profile out;
  out.best = fit_at(design, measured, rate_at(middle));
  const auto unknowns = static_cast<double>(out.best.coefficients.size() + 1);
  const double variance =
      out.best.squares / std::max(1.0, static_cast<double>(measured.size()) - unknowns);
  out.allowed = kChiSquare95 * variance;
  const double limit = out.best.squares + out.allowed;
  const auto edge = [&](double inside, double outside, bool& open) {
    open = squares(outside) <= limit;
    if (open) return outside;
    for (int i = 0; i < kHalvings; ++i) {
      const double half = 0.5 * (inside + outside);
      (squares(half) <= limit ? inside : outside) = half;
    }
    return inside;
  };
  const double from = edge(middle, 0, out.open_low);
  const double to = edge(middle, 1, out.open_high);
  for (int n = 0; n <= kProfile; ++n) {
    const double share = from + (to - from) * n / kProfile;
    out.within.push_back(fit_at(design, measured, rate_at(share)));
  }
  return out;
}

// Profile of value(rate, coefficient), monotone in the coefficient.
Estimate estimate(const Profile& profile, Index coefficient,
                  const std::function<double(double rate, double coefficient)>& value) {
  Estimate out;
  out.value = value(profile.best.rate, profile.best.coefficients[coefficient]);
  out.low = out.high = out.value;
  out.open_low = profile.open_low;
  out.open_high = profile.open_high;
  for (const Linear& fit : profile.within) {
    const double left = profile.allowed - (fit.squares - profile.best.squares);
    const double half = std::sqrt(std::max(0.0, left) * fit.spread[coefficient]);
    for (const double sign : {-1.0, 1.0}) {
      const double at = value(fit.rate, fit.coefficients[coefficient] + sign * half);
      if (!std::isfinite(at)) continue;
      out.low = std::min(out.low, at);
      out.high = std::max(out.high, at);
    }
  }
  return out;
}

VectorXd as_vector(const std::vector<double>& values) {
  return Eigen::Map<const VectorXd>(values.data(), static_cast<Index>(values.size()));
}

std::vector<double> as_list(const VectorXd& values) {
  return {values.data(), values.data() + values.size()};
}

double rms(const VectorXd& values) {
  return std::sqrt(values.squaredNorm() / static_cast<double>(values.size()));
}

}  // namespace

void Recording::check() const {
  if (time_s.size() < kFewestSamples) throw_invalid("a recording must have 20 samples or more");
  if (position_m.size() != time_s.size() || force_n.size() != time_s.size()) {
    throw_invalid("a recording must have a position and a force at every time");
  }
  for (std::size_t n = 0; n < time_s.size(); ++n) {
    if (!std::isfinite(time_s[n]) || !std::isfinite(position_m[n]) || !std::isfinite(force_n[n])) {
      throw_invalid("sample " + std::to_string(n) + " of the recording is no number");
    }
    if (n > 0 && !(time_s[n] > time_s[n - 1])) {
      throw_invalid("the recording's times do not rise at sample " + std::to_string(n));
    }
  }
  const auto [least, most] = std::minmax_element(position_m.begin(), position_m.end());
  if (!(*most > *least))
    throw_invalid("nothing moves in the recording; record a stretch or a press");
}

HorizontalFit identify_horizontal(const Recording& relaxation) {
  relaxation.check();
  const auto count = static_cast<Index>(relaxation.time_s.size());
  const VectorXd t = as_vector(relaxation.time_s).array() - relaxation.time_s.front();
  const VectorXd x = as_vector(relaxation.position_m).array() - relaxation.position_m.front();
  const VectorXd force = as_vector(relaxation.force_n);
  const Design design = [&](double rate) {
    MatrixXd columns(count, 4);
    double branch = 0;  // of a unit spring behind its damper: exact between the samples
    for (Index n = 0; n < count; ++n) {
      if (n > 0) {
        const double z = -rate * (t[n] - t[n - 1]);
        branch = std::exp(z) * branch + (x[n] - x[n - 1]) * phi1(z);
      }
      columns.row(n) << x[n], branch, std::exp(-rate * t[n]), 1;
    }
    return columns;
  };
  const Profile found = profile(design, force, 1, 300);
  HorizontalFit out;
  out.k_h2_n_per_m = estimate(found, 0, [](double, double k) { return k; });
  out.k_h1_n_per_m = estimate(found, 1, [](double, double k) { return k; });
  out.c_h_n_s_per_m = estimate(found, 1, [](double rate, double k) { return k / rate; });
  out.asymptote_n = found.best.coefficients[3];
  if (!(out.k_h1_n_per_m.value > 0 && out.k_h2_n_per_m.value > 0)) {
    throw_invalid(
        "no positive springs fit the relaxation; give the force with which the muscle pulls when "
        "its stretch grows, and a stretch that is not over before the force has fallen");
  }
  const VectorXd fitted = design(found.best.rate) * found.best.coefficients;
  out.fitted_n = as_list(fitted);
  out.rms_n = rms(force - fitted);
  return out;
}

VerticalFit identify_vertical(const Recording& press) {
  press.check();
  const auto count = static_cast<Index>(press.time_s.size());
  const VectorXd t = as_vector(press.time_s).array() - press.time_s.front();
  const VectorXd dent = as_vector(press.position_m);
  const std::vector<double>& force = press.force_n;
  const Design design = [&](double rate) {
    MatrixXd columns(count, 2);
    double moved = 0;  // of a unit damper beside a spring: exact between the samples
    for (Index n = 0; n < count; ++n) {
      if (n > 0) {
        const auto at = static_cast<std::size_t>(n);
        const double h = t[n] - t[n - 1];
        const double z = -rate * h;
        moved = std::exp(z) * moved + h * phi1(z) * force[at - 1] +
                h * phi2(z) * (force[at] - force[at - 1]);
      }
      columns.row(n) << moved, std::exp(-rate * t[n]);
    }
    return columns;
  };
  const Profile found = profile(design, dent, 0.05, 100);
  if (!(found.best.coefficients[0] > 0)) {
    throw_invalid("no positive spring and damper fit the press; give force and dent of one sign");
  }
  VerticalFit out;
  out.c_v_n_s_per_m = estimate(found, 0, [](double, double c) { return c > 0 ? 1 / c : INFINITY; });
  out.k_v_n_per_m =
      estimate(found, 0, [](double rate, double c) { return c > 0 ? rate / c : INFINITY; });
  const VectorXd fitted = design(found.best.rate) * found.best.coefficients;
  out.fitted_m = as_list(fitted);
  out.rms_m = rms(dent - fitted);
  return out;
}

}  // namespace beatlas::identify
