#include "pipeline/ingest/trigger_times.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace beatlas::ingest {
namespace {

constexpr double kSameTimeMs = 0.9;   // below the printed step: the same instant
constexpr std::size_t kPerTime = 4;   // more images than this at one time: times mean nothing
constexpr double kLeastInUnit = 0.6;  // in them, less may as well be several beats in ms
constexpr double kLeastBeatMs = 400;  // if no R-R interval is printed
constexpr double kMostBeatMs = 6000;
constexpr double kMostBeatsAStep = 4;  // one image every so many beats is perfusion
constexpr double kLatestStart = 1.05;  // [R-R] of a beat's first frame, as rates go up and down

struct Unit {
  double ms;
  const char* name;
};
constexpr std::array kUnits = {Unit{1, ""}, Unit{1000, "seconds"},
                               Unit{0.1, "tenths of a millisecond"}, Unit{0.001, "microseconds"}};

double trigger(const std::vector<FrameStamp>& stamps, int index) {
  return *stamps[static_cast<std::size_t>(index)].trigger_ms;
}

/// Frames that differ in time, in one unit.
struct Reading {
  std::vector<int> order;
  std::vector<double> ms;

  [[nodiscard]] double span() const { return ms.back() - ms.front(); }
  [[nodiscard]] double stepped() const {
    const auto count = static_cast<double>(ms.size());
    return span() / (count - 1) * count;
  }
};

/// @param sorted by trigger time
Reading read_in(const std::vector<FrameStamp>& stamps, const std::vector<int>& sorted,
                double unit_ms) {
  Reading out;
  for (const int index : sorted) {
    const double ms = trigger(stamps, index) * unit_ms;
    if (!out.ms.empty() && ms - out.ms.back() < kSameTimeMs) continue;
    out.order.push_back(index);
    out.ms.push_back(ms);
  }
  return out;
}

bool distinct(const Reading& reading, std::size_t images) {
  return reading.ms.size() >= 2 && reading.ms.size() * kPerTime >= images;
}

/// Whether the times are those of one beat, without any doubt.
bool fits(const Reading& reading, double printed_ms, double least_of_rr) {
  const double rr_ms = printed_ms > 0 ? printed_ms : reading.stepped();
  return plausible_rr(rr_ms * 1e-3) && reading.span() < rr_ms &&
         reading.stepped() >= least_of_rr * rr_ms &&
         std::abs(reading.ms.front()) <= kLatestStart * rr_ms;
}

double median_step(const Reading& reading) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < reading.ms.size(); ++i) {
    steps.push_back(reading.ms[i] - reading.ms[i - 1]);
  }
  std::sort(steps.begin(), steps.end());
  return steps[steps.size() / 2];
}

/// About one image every beat, or every second, ...
bool steps_by_beats(const Reading& reading, double printed_ms) {
  const double step = median_step(reading);
  if (printed_ms <= 0) {
    return reading.ms.size() >= 8 && step >= kLeastBeatMs && step <= kMostBeatMs &&
           reading.span() > 5000;
  }
  const double beats = step / printed_ms;
  return reading.span() > 1.5 * printed_ms && beats > 0.85 && beats < kMostBeatsAStep + 0.15 &&
         std::abs(beats - std::round(beats)) < 0.15;
}

/// If the images, by instance number, run through the cycle twice: those of the first run.
std::vector<int> first_run(const std::vector<FrameStamp>& stamps, const std::vector<int>& all) {
  std::vector<int> order = all;
  const auto instance = [&](int i) { return stamps[static_cast<std::size_t>(i)].instance; };
  if (!std::all_of(all.begin(), all.end(), [&](int i) { return instance(i).has_value(); })) {
    return all;
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return *instance(a) < *instance(b); });
  std::size_t fall = 0;
  for (std::size_t i = 1; i < order.size(); ++i) {
    if (trigger(stamps, order[i]) >= trigger(stamps, order[i - 1])) continue;
    if (fall > 0) return all;
    fall = i;
  }
  if (fall < kLeastOfBeat || 5 * fall < 2 * order.size() || 5 * fall > 3 * order.size()) return all;
  const double low = std::max(trigger(stamps, order[0]), trigger(stamps, order[fall]));
  const double high = std::min(trigger(stamps, order[fall - 1]), trigger(stamps, order.back()));
  const double span = std::max(trigger(stamps, order[fall - 1]), trigger(stamps, order.back())) -
                      std::min(trigger(stamps, order[0]), trigger(stamps, order[fall]));
  if (high - low < 0.6 * span) return all;  // one cycle that the numbering starts in its middle
  order.resize(fall);
  return order;
}

void add_note(std::string& note, const std::string& more) {
  note += (note.empty() ? "" : ", ") + more;
}

/// Times of one beat that go on from slice to slice, not from R wave to R wave: they count from
/// the first frame, for the beats between are not recorded. @return whether they do
bool count_from_first(Reading& reading, double printed_ms) {
  const double rr_ms = printed_ms > 0 ? printed_ms : reading.stepped();
  if (!plausible_rr(rr_ms * 1e-3) || reading.span() >= rr_ms ||
      reading.ms.front() <= kLatestStart * rr_ms) {
    return false;
  }
  const double first_ms = reading.ms.front();
  for (double& ms : reading.ms) ms -= first_ms;
  return true;
}

/// Keeps the first of several beats; true if there are several.
bool keep_first_beat(Reading& reading, double printed_ms) {
  if (printed_ms <= 0 || reading.stepped() < kSeveralBeats * printed_ms) return false;
  const double end = reading.ms.front() + printed_ms - 0.5 * median_step(reading);
  const auto count = static_cast<std::size_t>(
      std::lower_bound(reading.ms.begin(), reading.ms.end(), end) - reading.ms.begin());
  if (count < kLeastOfBeat) return false;
  reading.order.resize(count);
  reading.ms.resize(count);
  return true;
}

/// Whether times in ms step as those of a cine do, but over several beats.
/// @param beat_ms how long one is, 0 if nothing tells
bool runs_over_beats(const Reading& reading, double beat_ms) {
  return ordinary_step(median_step(reading)) &&
         (beat_ms > 0 ? reading.stepped() >= kSeveralBeats * beat_ms
                      : !plausible_rr(reading.stepped() * 1e-3));
}

/// Reads the times in the first unit other than ms in which they are those of one beat.
/// @return false if there is none
bool take_other_unit(const std::vector<FrameStamp>& stamps, const std::vector<int>& sorted,
                     double printed_ms, Reading& reading, std::string& note) {
  for (std::size_t u = 1; u < kUnits.size(); ++u) {
    Reading other = read_in(stamps, sorted, kUnits[u].ms);
    if (!distinct(other, sorted.size()) || !fits(other, printed_ms, kLeastInUnit)) continue;
    reading = std::move(other);
    add_note(note, std::string("the trigger times were taken as ") + kUnits[u].name);
    return true;
  }
  return false;
}

/// Sets the R-R interval: as printed, but for what the times say against it or more finely.
/// @param beat_unknown several beats, and nothing tells how long one is
/// @return false if the times do not lie within one
bool set_rr(const Reading& reading, double printed_s, bool beat_unknown, SliceTiming& timing) {
  const double stepped_s = reading.stepped() * 1e-3;
  timing.rr_s = printed_s;
  if (printed_s == 0 || reading.span() >= printed_s * 1e3) {
    if (!beat_unknown && !plausible_rr(stepped_s)) return false;
    timing.beat_unknown = beat_unknown;
    add_note(timing.note, beat_unknown ? "several beats were recorded"
                          : printed_s == 0
                              ? "no R-R interval is recorded, frames x step was taken"
                              : "the trigger times reach beyond the recorded R-R interval, "
                                "frames x step was taken");
    timing.rr_s = beat_unknown ? 0 : stepped_s;
  } else if (std::abs(stepped_s - printed_s) <= kRoundingMs * 1e-3) {
    timing.rr_s = stepped_s;
  }
  return true;
}

}  // namespace

TriggerReading read_triggers(const std::vector<FrameStamp>& stamps, double printed_s,
                             double given_s) {
  TriggerReading out;
  std::vector<int> all(stamps.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
  if (!std::all_of(stamps.begin(), stamps.end(),
                   [](const FrameStamp& stamp) { return stamp.trigger_ms.has_value(); })) {
    out.why_not = "not every image has a trigger time";
    return out;
  }
  SliceTiming timing;
  std::vector<int> sorted = first_run(stamps, all);
  if (sorted.size() < all.size()) {
    add_note(timing.note, "the cycle was recorded twice, the first recording was taken");
  }
  std::stable_sort(sorted.begin(), sorted.end(),
                   [&](int a, int b) { return trigger(stamps, a) < trigger(stamps, b); });

  const double printed_ms = printed_s * 1e3;
  Reading reading = read_in(stamps, sorted, 1);
  const bool differ = distinct(reading, sorted.size());
  if (differ && count_from_first(reading, printed_ms)) {
    add_note(timing.note,
             "the trigger times go on from one slice to the next and were counted from the slice's "
             "first frame");
  }
  bool sure = differ && fits(reading, printed_ms, kLeastOfRr);
  if (!sure && differ && steps_by_beats(reading, printed_ms)) {
    out.many_beats = true;
    out.why_not = "the trigger times step by whole beats";
    return out;
  }
  const double beat_ms = printed_s > 0 ? printed_ms : given_s * 1e3;
  const bool beats = differ && runs_over_beats(reading, beat_ms);
  if (!sure && !beats) sure = take_other_unit(stamps, sorted, printed_ms, reading, timing.note);
  if (!sure && !differ) {
    out.why_not = "the trigger times do not differ";
    return out;
  }
  const std::size_t shared = sorted.size() - reading.ms.size();
  if ((!sure || (printed_s == 0 && beats)) && keep_first_beat(reading, beat_ms)) {
    add_note(timing.note, "several beats were recorded, the first was taken");
  }
  if (!set_rr(reading, printed_s, beats && beat_ms <= 0, timing)) {
    out.why_not = "the trigger times do not lie within one R-R interval";
    return out;
  }
  if (shared > 0) {
    add_note(timing.note,
             std::to_string(shared) + " images that share a trigger time with another were left");
  }
  timing.order = std::move(reading.order);
  for (const double ms : reading.ms) {
    timing.time_s.push_back(ms / 1e3);  // 348 ms is 0.348 s, to the last bit
  }
  timing.timed = timing.by_trigger = true;
  timing.source = "TriggerTime";
  out.timing = std::move(timing);
  return out;
}

}  // namespace beatlas::ingest
