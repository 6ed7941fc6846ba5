#include "pipeline/ingest/slice_timing.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "pipeline/ingest/trigger_times.h"

namespace beatlas::ingest {
namespace {

constexpr double kMostUnevenStep = 2.5;  // of the median: clock times that jump order nothing
constexpr std::size_t kLeastOfMany = 8;  // images before their clock tells that they span beats
constexpr double kBeatStepS = 0.4;       // 150 beats a minute

using Field = std::optional<double> FrameStamp::*;

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// The slice's R-R interval as its images print it; 0 if they do not or it makes no sense.
double printed_rr_s(const std::vector<FrameStamp>& stamps) {
  std::vector<double> values;
  for (const FrameStamp& stamp : stamps) {
    if (stamp.rr_ms) values.push_back(*stamp.rr_ms * 1e-3);
  }
  if (values.empty()) return 0;
  const double rr = median(values);
  return plausible_rr(rr) ? rr : 0;
}

/// The images by one field; nothing if one lacks it or two have the same.
std::optional<std::vector<int>> ordered_by(const std::vector<FrameStamp>& stamps, Field key) {
  std::vector<int> order(stamps.size());
  std::iota(order.begin(), order.end(), 0);
  const auto value = [&](int i) { return stamps[static_cast<std::size_t>(i)].*key; };
  if (!std::all_of(order.begin(), order.end(), [&](int i) { return value(i).has_value(); })) {
    return std::nullopt;
  }
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return *value(a) < *value(b); });
  const bool same = std::adjacent_find(order.begin(), order.end(), [&](int a, int b) {
                      return *value(a) == *value(b);
                    }) != order.end();
  if (same) return std::nullopt;
  return order;
}

/// Whether images lie in the order of their numbers, or in its reverse; also if they have none. A
/// clock that says otherwise may be that of whoever wrote the files.
bool in_order_of_number(const std::vector<FrameStamp>& stamps, const std::vector<int>& order) {
  const auto numbered = ordered_by(stamps, &FrameStamp::instance);
  return !numbered || *numbered == order ||
         std::equal(order.begin(), order.end(), numbered->rbegin(), numbered->rend());
}

struct Steps {
  double median = 0;
  double most = 0;
  double stepped = 0;  ///< images x mean step
};

Steps steps_of(const std::vector<FrameStamp>& stamps, const std::vector<int>& order, Field key) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < order.size(); ++i) {
    steps.push_back(*(stamps[static_cast<std::size_t>(order[i])].*key) -
                    *(stamps[static_cast<std::size_t>(order[i - 1])].*key));
  }
  const double span = std::accumulate(steps.begin(), steps.end(), 0.0);
  return {median(steps), *std::max_element(steps.begin(), steps.end()),
          span / static_cast<double>(steps.size()) * static_cast<double>(order.size())};
}

/// Clock times that order frames of one beat.
bool sound(const Steps& steps) {
  return steps.most <= kMostUnevenStep * steps.median && plausible_rr(steps.stepped);
}

/// The clock says that about one image a beat was taken.
bool beats_by_clock(const std::vector<FrameStamp>& stamps) {
  const auto order = ordered_by(stamps, &FrameStamp::acquisition_s);
  if (!order || order->size() < kLeastOfMany) return false;
  const Steps steps = steps_of(stamps, *order, &FrameStamp::acquisition_s);
  return steps.median >= kBeatStepS && steps.most <= kMostUnevenStep * steps.median;
}

/// Times that go on for several beats: keeps the first, if it is known how long one is.
/// @return whether they do
bool one_beat(SliceTiming& timing, double beat_s) {
  const auto count = static_cast<double>(timing.time_s.size());
  const double step_s = (timing.time_s.back() - timing.time_s.front()) / (count - 1);
  if (!ordinary_step(1e3 * step_s)) return false;
  if (beat_s <= 0) {
    timing.beat_unknown = step_s * count > kMostRrS;
    return timing.beat_unknown;
  }
  const auto beat = static_cast<std::size_t>(beat_s / step_s + 0.02);
  if (step_s * count < kSeveralBeats * beat_s || beat < kLeastOfMany) return false;
  timing.order.resize(beat);
  timing.time_s.resize(beat);
  timing.rr_s = beat_s;
  timing.note += ", several beats were recorded, the first was taken";
  return true;
}

/// Frames whose clock goes on for several beats.
std::optional<SliceTiming> by_clock_of_beats(const std::vector<FrameStamp>& stamps, double beat_s) {
  const auto order = ordered_by(stamps, &FrameStamp::acquisition_s);
  if (!order || order->size() < kLeastOfMany) return std::nullopt;
  const Steps steps = steps_of(stamps, *order, &FrameStamp::acquisition_s);
  if (steps.most > kMostUnevenStep * steps.median || !in_order_of_number(stamps, *order)) {
    return std::nullopt;
  }
  SliceTiming out;
  out.order = *order;
  const double start_s = *stamps[static_cast<std::size_t>(order->front())].acquisition_s;
  for (const int i : *order) {
    out.time_s.push_back(*stamps[static_cast<std::size_t>(i)].acquisition_s - start_s);
  }
  if (!one_beat(out, beat_s)) return std::nullopt;
  out.timed = true;
  out.source = "AcquisitionTime";
  out.note = ", AcquisitionTime gives the times" + out.note;
  return out;
}

std::optional<SliceTiming> by_elapsed(const std::vector<FrameStamp>& stamps, double printed_s,
                                      double beat_s) {
  const auto order = ordered_by(stamps, &FrameStamp::elapsed_ms);
  if (!order) return std::nullopt;
  SliceTiming out;
  out.order = *order;
  for (const int i : *order) {
    out.time_s.push_back(*stamps[static_cast<std::size_t>(i)].elapsed_ms / 1e3);
  }
  const double span = out.time_s.back() - out.time_s.front();
  const auto count = static_cast<double>(order->size());
  const double stepped = span / (count - 1) * count;
  out.rr_s = printed_s > span ? printed_s : stepped;
  out.timed = true;
  out.source = "FrameTimeVector";
  if (one_beat(out, beat_s)) return out;
  if (!plausible_rr(stepped)) return std::nullopt;
  return out;
}

/// The order that the best of the remaining fields gives.
std::optional<SliceTiming> by_order(const std::vector<FrameStamp>& stamps) {
  struct Key {
    Field field;
    const char* name;
    bool clock;
  };
  std::string contradicted;
  for (const Key& key : {Key{&FrameStamp::temporal_position, "TemporalPosition", false},
                         Key{&FrameStamp::acquisition_s, "AcquisitionTime", true},
                         Key{&FrameStamp::content_s, "ContentTime", true},
                         Key{&FrameStamp::instance, "InstanceNumber", false}}) {
    const auto order = ordered_by(stamps, key.field);
    if (!order || (key.clock && !sound(steps_of(stamps, *order, key.field)))) continue;
    if (key.clock && !in_order_of_number(stamps, *order)) {
      contradicted += (contradicted.empty() ? ", against " : " and ") + std::string(key.name);
      continue;
    }
    SliceTiming out;
    out.order = *order;
    out.source = key.name;
    if (!contradicted.empty()) out.note = contradicted + ", which jumps from number to number,";
    return out;
  }
  return std::nullopt;
}

/// Gives ordered frames their times: steps of FrameTime where they fit, else even ones.
void space_out(SliceTiming& timing, double frame_time_s, double printed_s, double given_s) {
  const double total = frame_time_s * static_cast<double>(timing.order.size());
  if (printed_s == 0 && ordinary_step(1e3 * frame_time_s) &&
      (given_s > 0 ? total >= kSeveralBeats * given_s : total > kMostRrS)) {
    timing.beat_unknown = given_s <= 0;
    printed_s = given_s;
  }
  timing.rr_s = printed_s;
  const bool stepped = frame_time_s > 0 && printed_s > 0 && total >= kLeastOfRr * printed_s;
  if (stepped && total >= kSeveralBeats * printed_s) {
    const auto beat = static_cast<std::size_t>(printed_s / frame_time_s + 0.02);
    if (beat >= kLeastOfBeat) {
      timing.order.resize(beat);
      timing.note += ", several beats were recorded, the first was taken";
    }
  }
  const auto count = static_cast<double>(timing.order.size());
  if (printed_s == 0 && plausible_rr(total)) timing.rr_s = total;
  const bool by_step = stepped && frame_time_s * count <= 1.02 * printed_s;
  const double step = by_step ? frame_time_s : timing.rr_s / count;
  for (std::size_t i = 0; i < timing.order.size(); ++i) {
    timing.time_s.push_back(step * static_cast<double>(i));
  }
  timing.timed = by_step;
  timing.note += by_step ? " and spaced by FrameTime" : " and spaced evenly";
}

}  // namespace

std::optional<SliceTiming> time_slice(const std::vector<FrameStamp>& stamps, double given_rr_s) {
  if (stamps.size() < 2) return std::nullopt;
  const double printed_s = printed_rr_s(stamps);
  TriggerReading triggers = read_triggers(stamps, printed_s, given_rr_s);
  if (triggers.timing) return triggers.timing;

  const bool many_beats = triggers.many_beats || beats_by_clock(stamps);
  const double beat_s = printed_s > 0 ? printed_s : given_rr_s;
  auto out = by_elapsed(stamps, printed_s, beat_s);
  if (out) {
    out->note = triggers.why_not + ", FrameTimeVector gives the times" + out->note;
  } else if ((out = by_clock_of_beats(stamps, beat_s))) {
    out->note = triggers.why_not + out->note;
  } else {
    out = by_order(stamps);
    if (!out) return std::nullopt;
    out->note = triggers.why_not + ", frames were ordered by " + out->source + out->note;
    space_out(*out, stamps.front().frame_time_ms.value_or(0) * 1e-3, printed_s, given_rr_s);
  }
  out->many_beats = many_beats;
  return out;
}

SliceTiming with_times(SliceTiming timing, const std::vector<double>& times_s, double rr_s) {
  const double span = times_s.back() - times_s.front();
  const auto count = static_cast<double>(times_s.size());
  timing.time_s = times_s;
  if (rr_s > 0) {
    timing.rr_s = rr_s;
  } else if (!(timing.rr_s > span)) {
    timing.rr_s = span / (count - 1) * count;
  }
  timing.timed = true;
  timing.many_beats = false;
  timing.source = "the times given";
  timing.note.clear();
  return timing;
}

std::optional<SliceTiming> with_rr(SliceTiming timing, double rr_s) {
  const bool shares =
      timing.rr_s > 0 && (!timing.timed || unseen_share(phases_of(timing, timing.rr_s)) == 0);
  if (!shares && timing.time_s.back() - timing.time_s.front() >= rr_s) return std::nullopt;
  if (shares) {
    for (double& at : timing.time_s) at *= rr_s / timing.rr_s;
  }
  timing.rr_s = rr_s;
  return timing;
}

std::vector<double> phases_of(const SliceTiming& timing, double rr_s) {
  const auto count = static_cast<double>(timing.order.size());
  const double rr = timing.rr_s > 0 ? timing.rr_s : rr_s;
  std::vector<double> out(timing.order.size());
  if (!timing.timed) {
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<double>(i) / count;
    return out;
  }
  double low = timing.time_s.front();
  double high = low;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double offset = timing.time_s[i] - rr * static_cast<double>(i) / count;
    low = std::min(low, offset);
    high = std::max(high, offset);
  }
  const bool even = high - low <= 2 * kRoundingMs * 1e-3;
  double start = 0.5 * (low + high);
  if (std::abs(start) <= kRoundingMs * 1e-3) start = 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double phase = even ? start / rr + static_cast<double>(i) / count : timing.time_s[i] / rr;
    const double part = phase - std::floor(phase);
    out[i] = part < 1 ? part : 0;  // of -1e-20 it is 1
  }
  return out;
}

double largest_gap(std::vector<double> phases) {
  std::sort(phases.begin(), phases.end());
  double gap = 1 - (phases.back() - phases.front());
  for (std::size_t i = 1; i < phases.size(); ++i) gap = std::max(gap, phases[i] - phases[i - 1]);
  return gap;
}

double unseen_share(const std::vector<double>& phases) {
  if (phases.size() < 3) return 0;
  const double gap = largest_gap(phases);
  const double step = (1 - gap) / static_cast<double>(phases.size() - 1);
  return gap >= 1.5 * step ? gap - step : 0;
}

}  // namespace beatlas::ingest
