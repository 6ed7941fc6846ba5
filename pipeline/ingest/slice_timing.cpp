#include "pipeline/ingest/slice_timing.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace beatlas::ingest {
namespace {

constexpr double kRoundingMs = 0.51;  // whole milliseconds
constexpr double kSameTimeMs = 0.9;   // below the printed step: the same instant
constexpr double kSpanOfRr = 1.0;     // frames of one beat begin within it
constexpr int kFramesPerTime = 4;     // more images than this at one time: times mean nothing

bool plausible(double rr_s) { return rr_s >= kLeastRrS && rr_s <= kMostRrS; }

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
  return plausible(rr) ? rr : 0;
}

std::vector<int> sorted_by(const std::vector<FrameStamp>& stamps,
                           std::optional<double> FrameStamp::*key) {
  std::vector<int> order(stamps.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return *(stamps[static_cast<std::size_t>(a)].*key) <
           *(stamps[static_cast<std::size_t>(b)].*key);
  });
  return order;
}

bool all_have(const std::vector<FrameStamp>& stamps, std::optional<double> FrameStamp::*key) {
  return std::all_of(stamps.begin(), stamps.end(),
                     [&](const FrameStamp& stamp) { return (stamp.*key).has_value(); });
}

std::optional<SliceTiming> by_trigger(const std::vector<FrameStamp>& stamps, double printed_s,
                                      std::string& why_not) {
  if (!all_have(stamps, &FrameStamp::trigger_ms)) {
    why_not = "not every image has a trigger time";
    return std::nullopt;
  }
  SliceTiming out;
  double last_ms = 0;
  for (const int index : sorted_by(stamps, &FrameStamp::trigger_ms)) {
    const double ms = *stamps[static_cast<std::size_t>(index)].trigger_ms;
    if (!out.order.empty() && ms - last_ms < kSameTimeMs) continue;
    out.order.push_back(index);
    out.time_s.push_back(ms / 1e3);  // 348 ms is 0.348 s, to the last bit
    last_ms = ms;
  }
  const std::size_t count = out.order.size();
  if (count < 2 || count * kFramesPerTime < stamps.size()) {
    why_not = "the trigger times do not differ";
    return std::nullopt;
  }
  const double span = out.time_s.back() - out.time_s.front();
  const double stepped = span / static_cast<double>(count - 1) * static_cast<double>(count);
  out.rr_s = printed_s;
  if (printed_s == 0 || span >= printed_s * kSpanOfRr) {
    if (!plausible(stepped)) {
      why_not = "the trigger times do not lie within one R-R interval";
      return std::nullopt;
    }
    out.note = printed_s == 0 ? "no R-R interval is recorded, frames x step was taken"
                              : "the trigger times reach beyond the recorded R-R interval, "
                                "frames x step was taken";
    out.rr_s = stepped;
  } else if (std::abs(stepped - printed_s) <= kRoundingMs * 1e-3) {
    out.rr_s = stepped;
  }
  if (count < stamps.size()) {
    out.note += (out.note.empty() ? "" : ", ") + std::to_string(stamps.size() - count) +
                " images that share a trigger time with another were left";
  }
  out.by_trigger = true;
  return out;
}

}  // namespace

std::optional<SliceTiming> time_slice(const std::vector<FrameStamp>& stamps) {
  if (stamps.size() < 2) return std::nullopt;
  const double printed_s = printed_rr_s(stamps);
  std::string why_not;
  if (auto timed = by_trigger(stamps, printed_s, why_not)) return timed;

  SliceTiming out;
  const char* name = nullptr;
  for (const auto& [key, key_name] : {std::pair{&FrameStamp::temporal_position, "TemporalPosition"},
                                      std::pair{&FrameStamp::instance, "InstanceNumber"}}) {
    if (!all_have(stamps, key)) continue;
    const auto order = sorted_by(stamps, key);
    const bool distinct = std::adjacent_find(order.begin(), order.end(), [&](int a, int b) {
                            return *(stamps[static_cast<std::size_t>(a)].*key) ==
                                   *(stamps[static_cast<std::size_t>(b)].*key);
                          }) == order.end();
    if (!distinct) continue;
    out.order = order;
    name = key_name;
    break;
  }
  if (!name) return std::nullopt;

  const auto count = static_cast<double>(out.order.size());
  out.rr_s = printed_s;
  if (out.rr_s == 0 && stamps.front().frame_time_ms) {
    const double stepped = *stamps.front().frame_time_ms * 1e-3 * count;
    if (plausible(stepped)) out.rr_s = stepped;
  }
  for (std::size_t i = 0; i < out.order.size(); ++i) {
    out.time_s.push_back(out.rr_s * static_cast<double>(i) / count);
  }
  out.note = why_not + ", frames were ordered by " + name + " and spaced evenly";
  return out;
}

std::vector<double> phases_of(const SliceTiming& timing, double rr_s) {
  const auto count = static_cast<double>(timing.order.size());
  const double rr = timing.rr_s > 0 ? timing.rr_s : rr_s;
  std::vector<double> out(timing.order.size());
  if (!timing.by_trigger) {
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

}  // namespace beatlas::ingest
