#include "pipeline/motion/slice_timing.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "pipeline/core/parallel.h"
#include "pipeline/core/statistics.h"
#include "pipeline/motion/narrow_field.h"
#include "runtime/base/error.h"

namespace beatlas::motion {
namespace {

constexpr std::size_t kMostLookedAt = 8192;  ///< pixels of a slice
constexpr int kFewestToCompare = 3;
constexpr int kFewestOfCourse = 8;    ///< of which a course is made
constexpr double kLeastInStep = 0.7;  ///< correlation with the others, half of what varies
constexpr double kCertainZ = 2;       ///< standard deviations of Fisher's z
constexpr double kLeastLag =
    0.07;  ///< of the beat; slices of real exams lie within a twentieth of it
constexpr double kMostLag = 0.5;       ///< of the beat: all the way round
constexpr double kFullBeat = 1.5;      ///< intervals between frames that may be missing at its end
constexpr int kLagRounds = 10;         ///< in which lags and the course they are told by settle
constexpr double kMostInStep = 0.999;  ///< beyond it z has no bound

/// [phase * phases + phase] how unlike two phases of a slice are: its course through the beat.
struct Course {
  std::size_t phases = 0;
  std::vector<double> unlike;

  /// The pairs of phases, each taken so many phases later.
  [[nodiscard]] std::vector<double> pairs(int later) const {
    std::vector<double> out;
    out.reserve(phases * (phases - 1) / 2);
    const std::size_t by = round_beat(later);
    for (std::size_t p = 0; p < phases; ++p) {
      for (std::size_t q = p + 1; q < phases; ++q) {
        out.push_back(unlike[((p + by) % phases) * phases + (q + by) % phases]);
      }
    }
    return out;
  }

 private:
  [[nodiscard]] std::size_t round_beat(int lag) const {
    const auto all = static_cast<int>(phases);
    return static_cast<std::size_t>((lag % all + all) % all);
  }
};

bool reaches_round(const Cine& cine) {
  const std::vector<double>& times = cine.frame_times_s;
  if (times.size() < 2) return true;
  const double shown = times.back() - times.front();
  return cine.rr_interval_s - shown <= kFullBeat * shown / static_cast<double>(times.size() - 1);
}

/// Pairs of mean 0 and norm 1, so that every slice has one voice; all 0 where nothing changes.
void standardise(Course& course) {
  double mean = 0;
  double square = 0;
  const std::vector<double> pairs = course.pairs(0);
  for (const double value : pairs) mean += value / static_cast<double>(pairs.size());
  for (const double value : pairs) square += (value - mean) * (value - mean);
  const double scale = square > 0 ? 1 / std::sqrt(square) : 0;
  for (double& value : course.unlike) value = (value - mean) * scale;
}

/// Root of the sum of squares by which pixels differ, standardised.
Course course_of(const ImageCycle<float>& images, std::size_t k) {
  const std::size_t count = images.grid.slice_count();
  const std::size_t step = (count / kMostLookedAt) | 1U;  // odd, so that columns are not skipped
  Course out{images.phases.size(), {}};
  out.unlike.assign(out.phases * out.phases, 0);
  for (std::size_t p = 0; p < out.phases; ++p) {
    for (std::size_t q = p + 1; q < out.phases; ++q) {
      double sum = 0;
      for (std::size_t v = k * count; v < (k + 1) * count; v += step) {
        const auto change = static_cast<double>(images.phases[q][v] - images.phases[p][v]);
        sum += change * change;
      }
      out.unlike[p * out.phases + q] = out.unlike[q * out.phases + p] = std::sqrt(sum);
    }
  }
  standardise(out);
  return out;
}

/// Pairs of phases of the others in step, without one slice: their medians.
std::vector<double> of_others(const std::vector<Course>& courses, const std::vector<int>& lags,
                              std::size_t without) {
  std::vector<std::vector<double>> in_step;
  for (std::size_t k = 0; k < courses.size(); ++k) {
    if (k != without) in_step.push_back(courses[k].pairs(lags[k]));
  }
  std::vector<double> out(in_step.front().size());
  for (std::size_t n = 0; n < out.size(); ++n) {
    std::vector<double> values;
    values.reserve(in_step.size());
    for (const std::vector<double>& pairs : in_step) values.push_back(pairs[n]);
    out[n] = median(std::move(values));
  }
  return out;
}

int likeliest_lag(const Course& course, const std::vector<double>& others) {
  const int most = static_cast<int>(kMostLag * static_cast<double>(course.phases));
  int out = 0;
  double best = correlation(course.pairs(0), others);
  for (int lag = -most; lag <= most; ++lag) {
    const double alike = correlation(course.pairs(lag), others);
    if (alike <= best) continue;
    best = alike;
    out = lag;
  }
  return out;
}

/// As they are against the middle one: the stack's beat is that of most slices.
void about_middle(std::vector<int>& lags) {
  std::vector<int> sorted = lags;
  std::sort(sorted.begin(), sorted.end());
  const int middle = sorted[sorted.size() / 2];
  for (int& lag : lags) lag -= middle;
}

bool is_certain(const Course& course, const std::vector<double>& others, int lag) {
  const auto phases = static_cast<double>(course.phases);
  const double in_step = correlation(course.pairs(lag), others);
  const double as_is = correlation(course.pairs(0), others);
  if (std::abs(lag) <= kLeastLag * phases || in_step < kLeastInStep) return false;
  const auto z = [](double r) { return std::atanh(std::clamp(r, -kMostInStep, kMostInStep)); };
  return z(in_step) - z(as_is) >= kCertainZ * std::sqrt(2 / (phases - 3));
}

}  // namespace

std::vector<int> slice_lags(const Cine& stack) {
  const auto slices = static_cast<std::size_t>(stack.grid().size[2]);
  std::vector<int> lags(slices, 0);
  if (stack.grid().size[2] < kFewestToCompare || stack.phase_count() < kFewestOfCourse ||
      is_narrow_field(stack.grid()) || !reaches_round(stack)) {
    return lags;
  }
  std::vector<Course> courses(slices);
  parallel_for(slices, [&](std::size_t k) { courses[k] = course_of(stack.images, k); });
  for (int round = 0; round < kLagRounds; ++round) {
    std::vector<int> found(slices);
    for (std::size_t k = 0; k < slices; ++k) {
      found[k] = likeliest_lag(courses[k], of_others(courses, lags, k));
    }
    about_middle(found);
    if (found == lags) break;
    lags = std::move(found);
  }
  std::vector<int> out(slices, 0);
  for (std::size_t k = 0; k < slices; ++k) {
    if (is_certain(courses[k], of_others(courses, lags, k), lags[k])) out[k] = lags[k];
  }
  return out;
}

ImageCycle<float> without_lags(ImageCycle<float> images, const std::vector<int>& lags) {
  if (lags.size() != static_cast<std::size_t>(images.grid.size[2])) {
    throw_invalid("there are " + std::to_string(lags.size()) + " lags for " +
                  std::to_string(images.grid.size[2]) + " slices");
  }
  const std::size_t count = images.grid.slice_count();
  const int phases = images.phase_count();
  for (std::size_t k = 0; k < lags.size(); ++k) {
    if (lags[k] % phases == 0) continue;
    const int by = (lags[k] % phases + phases) % phases;
    std::vector<std::vector<float>> slice;
    for (const std::vector<float>& phase : images.phases) {
      const auto first = phase.begin() + static_cast<std::ptrdiff_t>(k * count);
      slice.emplace_back(first, first + static_cast<std::ptrdiff_t>(count));
    }
    for (int p = 0; p < phases; ++p) {
      const std::vector<float>& from = slice[static_cast<std::size_t>((p + by) % phases)];
      std::copy(from.begin(), from.end(),
                images.phases[static_cast<std::size_t>(p)].begin() +
                    static_cast<std::ptrdiff_t>(k * count));
    }
  }
  return images;
}

Exam with_slices_in_step(Exam exam) {
  const std::vector<int> lags = slice_lags(exam.stack);
  const auto moved = std::count_if(lags.begin(), lags.end(), [](int lag) { return lag != 0; });
  if (moved == 0) return exam;
  const auto most = std::max_element(lags.begin(), lags.end(),
                                     [](int a, int b) { return std::abs(a) < std::abs(b); });
  const int phases = exam.stack.phase_count();
  exam.decisions.push_back("Warning: " + std::to_string(moved) + " of " +
                           std::to_string(lags.size()) +
                           " slices show the beat out of step with the others (most slice " +
                           std::to_string(most - lags.begin()) + ", whose frames come " +
                           std::to_string(std::abs(*most)) + " of " + std::to_string(phases) +
                           " phases too " + (*most > 0 ? "late" : "early") +
                           "); their frames were moved round the beat; /import/align_slices off in "
                           "a recipe leaves them.");
  exam.stack.images = without_lags(std::move(exam.stack.images), lags);
  exam.slice_lags = lags;
  return exam;
}

}  // namespace beatlas::motion
