/// The staircase against observers whose thresholds are stated.
#include "runtime/exercise/staircase.h"

#include <algorithm>
#include <cmath>
#include <iostream>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "runtime/exercise/random.h"

namespace beatlas::exercise {
namespace {

struct Runs {
  int within_two_percent = 0;
  int within_interval = 0;
  double mean = 0;
};

/// Observers of one threshold who answer by chance, each at a staircase of 40 trials.
Runs runs_of(double threshold, const Psychometric& observer, const StaircaseOptions& options,
             int count) {
  Runs out;
  for (int run = 0; run < count; ++run) {
    Random random(static_cast<std::uint64_t>(1000 * run + 7));
    Staircase staircase(options);
    while (!staircase.done()) {
      const double difference = staircase.next();
      staircase.answer(difference, random.unit() < observer.right(difference, threshold));
    }
    const Staircase::Estimate found = staircase.estimate();
    out.within_two_percent += std::abs(found.threshold - threshold) <= 0.02 ? 1 : 0;
    out.within_interval += found.low <= threshold && threshold <= found.high ? 1 : 0;
    out.mean += found.threshold / count;
  }
  return out;
}

TEST(Staircase, FindsStatedThresholdsInFortyTrials) {
  constexpr int kRuns = 200;
  for (const double threshold : {0.05, 0.08, 0.12}) {
    const Runs runs = runs_of(threshold, {}, {}, kRuns);
    EXPECT_GE(runs.within_two_percent, 0.95 * kRuns) << threshold;
    EXPECT_NEAR(runs.mean, threshold, 0.005) << threshold;
    // The interval holds 90 %: of 200 runs at least 85 % in all but one of 50 trials.
    EXPECT_GE(runs.within_interval, 0.85 * kRuns) << threshold;
    std::cout << "threshold " << threshold << ": " << runs.within_two_percent << " of " << kRuns
              << " within .02, interval holds " << runs.within_interval << '\n';
  }
}

TEST(Staircase, StandsObserversOfAnotherSlope) {
  Psychometric flat;
  flat.slope = 2.5;
  const Runs runs = runs_of(0.08, flat, {}, 200);
  EXPECT_GE(runs.within_two_percent, 0.8 * 200);
  EXPECT_NEAR(runs.mean, 0.08, 0.01);
}

TEST(Staircase, OneWhoFeelsNothingHasTheLargestThreshold) {
  Staircase staircase(StaircaseOptions{});
  for (int n = 0; !staircase.done(); ++n) staircase.answer(staircase.next(), n % 4 == 0);
  EXPECT_GT(staircase.estimate().threshold, 0.4);
}

TEST(Staircase, OneWhoFeelsAllHasTheLeast) {
  Staircase staircase(StaircaseOptions{});
  while (!staircase.done()) staircase.answer(staircase.next(), true);
  EXPECT_LT(staircase.estimate().threshold, 0.015);
}

TEST(Staircase, AsksNearTheThresholdInTheEnd) {
  Staircase staircase(StaircaseOptions{});
  Random random(3);
  double last = 1;
  EXPECT_EQ(staircase.next(), 0.3);
  while (!staircase.done()) {
    last = staircase.next();
    staircase.answer(last, random.unit() < Psychometric{}.right(last, 0.1));
  }
  EXPECT_GT(last, 0.07);
  EXPECT_LT(last, 0.16);
}

TEST(Staircase, RefusesWhatIsNone) {
  EXPECT_THROW(Staircase({.least = 0}), Error);
  EXPECT_THROW(Staircase({.least = 0.3, .most = 0.2}), Error);
  EXPECT_THROW(Staircase({.trials = 0}), Error);
  EXPECT_THROW(Staircase({.first = 0}), Error);
  StaircaseOptions guesses;
  guesses.observer.guess = 1;
  EXPECT_THROW(Staircase{guesses}, Error);
}

}  // namespace
}  // namespace beatlas::exercise
