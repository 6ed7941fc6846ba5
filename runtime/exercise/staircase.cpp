#include "runtime/exercise/staircase.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "runtime/base/error.h"

namespace beatlas::exercise {
namespace {

constexpr int kThresholds = 96;   ///< steps of the belief: 4.5 % each from 0.01 to 0.68
constexpr int kDifferences = 40;  ///< that are weighed for the next trial
constexpr double kSpread = 0.7;   ///< of the first belief, in the natural logarithm: a factor of 2
/// Thresholds beyond what can be shown are believed possible as well, by this factor.
constexpr double kBeyond = 1.5;

std::vector<double> steps(double low, double high, int count) {
  std::vector<double> out;
  for (int n = 0; n < count; ++n) out.push_back(low * std::pow(high / low, n / (count - 1.0)));
  return out;
}

double entropy(const std::vector<double>& weights, double sum) {
  double out = 0;
  for (const double weight : weights) {
    const double share = weight / sum;
    if (share > 0) out -= share * std::log(share);
  }
  return out;
}

}  // namespace

double Psychometric::right(double difference, double threshold) const noexcept {
  return guess + (1 - guess - lapse) * (1 - std::exp(-std::pow(difference / threshold, slope)));
}

Staircase::Staircase(const StaircaseOptions& options) : options_(options) {
  const Psychometric& observer = options.observer;
  if (!(options.least > 0 && options.least < options.most && options.most <= 1)) {
    throw_invalid("a staircase's differences must be above 0, at most 1, and rise");
  }
  if (!(options.first > 0 && options.first <= 1) || options.trials < 1) {
    throw_invalid("a staircase begins at a difference above 0, and has a trial at least");
  }
  if (!(observer.guess >= 0 && observer.lapse >= 0 && observer.guess + observer.lapse < 1 &&
        observer.slope > 0)) {
    throw_invalid("an observer guesses and slips less than always, and has a slope above 0");
  }
  thresholds_ = steps(options.least, kBeyond * options.most, kThresholds);
  differences_ = steps(options.least, options.most, kDifferences);
  // A person is asked first about a difference that most people feel.
  const double awaited = 0.5 * options.first;
  double sum = 0;
  for (const double threshold : thresholds_) {
    const double away = std::log(threshold / awaited) / kSpread;
    belief_.push_back(std::exp(-0.5 * away * away));
    sum += belief_.back();
  }
  for (double& share : belief_) share /= sum;
  for (const double difference : differences_) {
    for (const double threshold : thresholds_) {
      right_.push_back(observer.right(difference, threshold));
    }
  }
}

double Staircase::next() const {
  if (answers_ == 0) return std::clamp(options_.first, options_.least, options_.most);
  double best = 0;
  double least = std::numeric_limits<double>::infinity();
  std::vector<double> if_right(belief_.size());
  std::vector<double> if_wrong(belief_.size());
  for (std::size_t d = 0; d < differences_.size(); ++d) {
    double right = 0;
    for (std::size_t n = 0; n < belief_.size(); ++n) {
      if_right[n] = belief_[n] * right_[d * belief_.size() + n];
      if_wrong[n] = belief_[n] - if_right[n];
      right += if_right[n];
    }
    const double unknown =
        right * entropy(if_right, right) + (1 - right) * entropy(if_wrong, 1 - right);
    if (unknown < least) {
      least = unknown;
      best = differences_[d];
    }
  }
  return best;
}

void Staircase::answer(double difference, bool right) {
  double sum = 0;
  for (std::size_t n = 0; n < belief_.size(); ++n) {
    const double chance = options_.observer.right(difference, thresholds_[n]);
    belief_[n] *= right ? chance : 1 - chance;
    sum += belief_[n];
  }
  for (double& share : belief_) share /= sum;
  ++answers_;
}

double Staircase::quantile(double share) const {
  double below = 0;
  for (std::size_t n = 0; n < belief_.size(); ++n) {
    if (below + belief_[n] < share && n + 1 < belief_.size()) {
      below += belief_[n];
      continue;
    }
    // A step's belief lies about it, half a step to either side in the logarithm.
    const double step = std::log(thresholds_[1] / thresholds_[0]);
    return thresholds_[n] * std::exp(step * ((share - below) / belief_[n] - 0.5));
  }
  return thresholds_.back();
}

Staircase::Estimate Staircase::estimate() const {
  constexpr double kTail = 0.05;
  double mean = 0;
  for (std::size_t n = 0; n < belief_.size(); ++n) mean += belief_[n] * std::log(thresholds_[n]);
  return {.threshold = std::exp(mean), .low = quantile(kTail), .high = quantile(1 - kTail)};
}

}  // namespace beatlas::exercise
