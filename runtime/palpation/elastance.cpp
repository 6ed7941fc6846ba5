#include "runtime/palpation/elastance.h"

#include <cmath>

namespace beatlas::palpation {
namespace {

constexpr double kRise = 1.32;
constexpr double kFall = 21.9;
constexpr double kRelaxesAfter = 0.2;
constexpr double kLogRiseAt = -1.194022473472768;   // ln 0.303
constexpr double kLogFallAt = -0.6772738314036552;  // ln 0.508
constexpr double kSteepestAt = 0.5847;              // where the log-slope of e is least

struct Shape {
  double value;
  double log_slope;  // d ln e / dx
};

// x of the period, > 0.
Shape shape(double x) noexcept {
  const double log_x = std::log(x);
  const double g1 = std::exp(kRise * (log_x - kLogRiseAt));
  const double g2 = std::exp(kFall * (log_x - kLogFallAt));
  return {g1 / (1 + g1) / (1 + g2), (kRise / (1 + g1) - kFall * g2 / (1 + g2)) / x};
}

// Where `f` falls through 0 between `low` and `high`, by the Illinois rule.
template <class F>
double falls_through_zero(F f, double low, double high) noexcept {
  double at_low = f(low);
  double at_high = f(high);
  int side = 0;
  for (int i = 0; i < 60 && high - low > 1e-14; ++i) {
    const double x = (low * at_high - high * at_low) / (at_high - at_low);
    const double value = f(x);
    if (std::abs(value) < 1e-13) return x;
    if (value > 0) {
      low = x;
      at_low = value;
      if (side > 0) at_high *= 0.5;
      side = 1;
    } else {
      high = x;
      at_high = value;
      if (side < 0) at_low *= 0.5;
      side = -1;
    }
  }
  return high;
}

}  // namespace

ElastanceCurve::ElastanceCurve(double period_s, double relaxation_rate_per_s) noexcept
    : period_s_(period_s), rate_per_s_(relaxation_rate_per_s) {
  const double fall = rate_per_s_ * period_s_;
  if (shape(kSteepestAt).log_slope <= -fall && shape(kRelaxesAfter).log_slope > -fall) {
    joint_ = falls_through_zero([fall](double x) { return shape(x).log_slope + fall; },
                                kRelaxesAfter, kSteepestAt);
  }
  joint_value_ = shape(joint_).value;
  end_value_ = joint_value_ * std::exp(-fall * (1 - joint_));
  // The maximum less the line: before the joint, where e' = end value. It is positive at 0.2 T.
  const double highest = falls_through_zero(
      [this](double x) {
        const Shape at = shape(x);
        return at.value * at.log_slope - end_value_;
      },
      kRelaxesAfter, std::fmin(joint_, kSteepestAt));
  scale_ = 1 / (shape(highest).value - highest * end_value_);
}

ElastanceCurve::Sample ElastanceCurve::at(double time_s) const noexcept {
  const double x = time_s / period_s_;
  if (!(x > 0)) return {0, -scale_ * end_value_ / period_s_};
  double value = 0;
  double slope = 0;  // a second
  if (x < joint_) {
    const Shape at = shape(x);
    value = at.value;
    slope = at.value * at.log_slope / period_s_;
  } else {
    value = joint_value_ * std::exp(-rate_per_s_ * period_s_ * (x - joint_));
    slope = -rate_per_s_ * value;
  }
  return {scale_ * (value - x * end_value_), scale_ * (slope - end_value_ / period_s_)};
}

}  // namespace beatlas::palpation
