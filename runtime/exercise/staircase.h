#pragma once
/// The least difference that a person feels, from answers to differences that are chosen one after
/// the other so that each tells most.

#include <vector>

namespace beatlas::exercise {

/// How often a difference x is found among several places: guess + (1 - guess - lapse) (1 -
/// exp(-(x / threshold)^slope)), a Weibull function (Watson and Pelli 1983, "QUEST",
/// doi:10.3758/BF03202828, whose slope 3.5 is used).
struct Psychometric {
  double guess = 0.25;  ///< right by chance: 1 over the number of places
  double lapse = 0.02;  ///< wrong by a slip, however large the difference
  double slope = 3.5;

  [[nodiscard]] double right(double difference, double threshold) const noexcept;
};

struct StaircaseOptions {
  Psychometric observer = {};
  double first =
      0.3;  ///< 0..1: difference of the first trial, where the threshold is awaited below
  double least = 0.01;  ///< 0..1: of differences that can be shown
  double most = 0.45;   ///< 0..1
  int trials = 40;      ///< >= 1
};

/// A Bayesian staircase: the belief about the threshold is a histogram over its logarithm; the next
/// difference is the one after whose answer least is expected to be left unknown (entropy;
/// Kontsevich and Tyler 1999, doi:10.1016/S0042-6989(98)00285-5). The same answers make the same
/// staircase.
class Staircase {
 public:
  /// @throws Error{InvalidInput} if an option is out of range.
  explicit Staircase(const StaircaseOptions& options);

  [[nodiscard]] bool done() const noexcept { return answers_ >= options_.trials; }
  [[nodiscard]] int answers() const noexcept { return answers_; }
  /// The difference to show next.
  [[nodiscard]] double next() const;
  /// @param difference that was shown, which need not be `next`'s
  void answer(double difference, bool right);

  struct Estimate {
    double threshold = 0;  ///< where 63 % of what is not guessed is found
    double low = 0;        ///< 5 % of the belief lie below
    double high = 0;       ///< 5 % above
  };
  [[nodiscard]] Estimate estimate() const;

 private:
  [[nodiscard]] double quantile(double share) const;

  StaircaseOptions options_;
  std::vector<double> thresholds_;
  std::vector<double> differences_;
  std::vector<double> belief_;  ///< [threshold], sums to 1
  std::vector<double> right_;   ///< [difference][threshold] how likely a right answer is
  int answers_ = 0;
};

}  // namespace beatlas::exercise
