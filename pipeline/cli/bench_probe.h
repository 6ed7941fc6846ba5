#pragma once
/// Clocks of `beatlas bench`: memory of a stage, time of a query, time of a load.

#include <ctime>
#include <optional>
#include <vector>

#include "pipeline/assess/truth_set.h"
#include "pipeline/core/statistics.h"

namespace beatlas::cli {

/// Memory that work took, in this process: before it, memory that was freed is given back to the
/// system and the kernel's mark of the highest resident memory is set back (/proc/self/clear_refs);
/// after it, that mark is read. A process of its own for each run would cost the values that runs
/// share; the price is that what libraries keep from earlier runs is not counted again.
class MemoryMeter {
 public:
  MemoryMeter();
  /// Highest resident memory since construction, above that at construction [MB]; none where the
  /// kernel does not let it be set back.
  [[nodiscard]] std::optional<double> added_mb() const;

 private:
  std::optional<double> before_mb_;
};

/// A place and a time to ask at; workspace [mm], [s].
struct Question {
  Vec3 x = Vec3::Zero();
  double t_s = 0;
};

/// The palpations at 1 kHz.
[[nodiscard]] std::vector<Question> path_questions(const assess::TruthSet& truth,
                                                   const Affine& workspace_from_lps,
                                                   double rr_interval_s);
/// Places within 3 mm of the heart's surface, in no order, at any time. Deterministic.
[[nodiscard]] std::vector<Question> random_questions(const assess::TruthSet& truth,
                                                     const Affine& workspace_from_lps,
                                                     double rr_interval_s);

[[nodiscard]] double wall_clock_s();
[[nodiscard]] double thread_cpu_s();

/// Median wall time of `run` [ms] over `repeats` runs; over three, once they have taken a second.
template <class Run>
[[nodiscard]] double median_wall_ms(int repeats, Run&& run) {
  constexpr std::size_t kFewest = 3;
  std::vector<double> taken;
  const double first = wall_clock_s();
  while (static_cast<int>(taken.size()) < repeats &&
         (taken.size() < kFewest || wall_clock_s() - first < 1)) {
    const double start = wall_clock_s();
    run();
    taken.push_back(1e3 * (wall_clock_s() - start));
  }
  return median(std::move(taken));
}

/// Nanoseconds of CPU time for one call, median over `repeats` rounds of all questions; one round
/// before them is not counted.
template <class Ask>
[[nodiscard]] double nanoseconds(const std::vector<Question>& questions, int repeats, Ask&& ask) {
  std::vector<double> rounds;
  double sum = 0;  // used below, so that no call is left out
  for (int round = 0; round <= repeats; ++round) {
    const double start = thread_cpu_s();
    for (const Question& question : questions) sum += ask(question.x, question.t_s);
    if (round > 0) {
      rounds.push_back(1e9 * (thread_cpu_s() - start) / static_cast<double>(questions.size()));
    }
  }
  volatile double used = sum;
  (void)used;
  return median(rounds);
}

}  // namespace beatlas::cli
