#include "pipeline/ingest/frame_timing.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "pipeline/ingest/phase_resampling.h"
#include "pipeline/ingest/slice_timing.h"
#include "runtime/base/error.h"

namespace beatlas::ingest {
namespace {

constexpr double kEven = 1e-3;          // of a step: what rounded decimals differ by
constexpr double kToldGap = 0.12;       // a pause of the images, as a share of the R-R interval
constexpr double kSameInterval = 0.01;  // R-R intervals that agree
// What tools write as a step of time where they know none, also in files that claim seconds.
constexpr double kUntoldStep = 1;
constexpr const char* kRrGiven = "The R-R interval was given, not taken from the file.";
constexpr const char* kByRr = "the given R-R interval";

bool plausible(double rr_s) { return rr_s >= kLeastRrS && rr_s <= kMostRrS; }

std::string seconds(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.4g s", value);
  return text;
}

/// Which time was believed, and the R-R interval that it makes.
void tell(const std::string& from, FrameTiming& out, const std::string& more = "") {
  out.decisions.push_back("Timing of the stack is by " + from + "; the R-R interval is " +
                          std::to_string(std::lround(out.rr_s * 1e3)) + " ms" + more + ".");
}

bool ascending(const std::vector<double>& times) {
  return std::all_of(times.begin(), times.end(), [](double t) { return std::isfinite(t); }) &&
         std::adjacent_find(times.begin(), times.end(), std::greater_equal<>()) == times.end();
}

/// The R-R interval that times make if the step from the last to the next beat is their mean one.
double stepped_rr(const std::vector<double>& times) {
  const auto count = static_cast<double>(times.size());
  return (times.back() - times.front()) * count / (count - 1);
}

/// 1 or 0.001, whichever makes an R-R interval of `rr`; 0 if neither does. Tells what is odd.
double unit_of(double rr, bool unit_known, std::vector<std::string>& decisions) {
  if (plausible(rr)) {
    if (!unit_known) {
      decisions.emplace_back("Warning: the file names no unit of time, seconds were taken.");
    }
    return 1;
  }
  if (plausible(rr * 1e-3)) {
    decisions.emplace_back(
        "Warning: the times of the file make an R-R interval only as milliseconds, these were "
        "taken.");
    return 1e-3;
  }
  return 0;
}

void set_phases(FrameTiming& out) {
  const auto count = static_cast<double>(out.time_s.size());
  const double step = out.rr_s / count;
  out.even = true;
  for (std::size_t p = 0; p < out.time_s.size(); ++p) {
    const double phase = (out.time_s[p] - out.time_s[0]) / out.rr_s;
    out.phases.push_back(phase);
    out.even =
        out.even && std::abs(phase * out.rr_s - step * static_cast<double>(p)) <= kEven * step;
  }
  if (out.even) {
    for (std::size_t p = 0; p < out.phases.size(); ++p) {
      out.phases[p] = static_cast<double>(p) / count;
    }
  } else if (const double gap = largest_gap(out.phases);
             gap > kToldGap && gap * count > 1.5 && out.phases.size() >= kLeastFramesToBlend) {
    out.decisions.push_back("Warning: the images leave out " +
                            std::to_string(std::lround(gap * 100)) +
                            " % of the R-R interval; what lies between is interpolated.");
  }
}

FrameTiming even_frames(double rr_s, int frames, const std::string& from,
                        std::vector<std::string> decisions) {
  FrameTiming out;
  out.rr_s = rr_s;
  out.decisions = std::move(decisions);
  for (int p = 0; p < frames; ++p) out.time_s.push_back(rr_s * p / frames);
  set_phases(out);
  tell(from, out, ", the times of the frames were taken as even over it");
  return out;
}

FrameTiming by_given_times(int frames, const IngestOptions& options) {
  FrameTiming out;
  out.time_s = options.frame_times_s;
  if (std::ssize(out.time_s) != frames) {
    throw_invalid("it holds " + std::to_string(frames) + " phases, but " +
                  std::to_string(out.time_s.size()) +
                  (out.time_s.size() == 1 ? " frame time was given" : " frame times were given"));
  }
  if (!ascending(out.time_s)) throw_invalid("the given frame times do not rise");
  out.rr_s = options.rr_interval_s > 0 ? options.rr_interval_s : stepped_rr(out.time_s);
  if (!plausible(out.rr_s) || out.time_s.back() - out.time_s.front() >= out.rr_s) {
    throw_invalid("the given frame times do not lie within an R-R interval of " +
                  seconds(out.rr_s) + "; give them in seconds, and the interval with --rr SECONDS");
  }
  if (options.rr_interval_s > 0) out.decisions.emplace_back(kRrGiven);
  out.decisions.emplace_back("The frame times were given, not taken from the file.");
  set_phases(out);
  tell("the given frame times", out);
  return out;
}

/// By the times that the file names one by one, if it does and they make an R-R interval.
/// @param decisions takes what is odd about times that are left
std::optional<FrameTiming> by_own_times(const formats::ImageFileHeader& header, int frames,
                                        double given_rr, std::vector<std::string>& decisions) {
  if (std::ssize(header.frame_times_s) != frames) return {};
  if (!ascending(header.frame_times_s)) {
    decisions.emplace_back("Warning: the frame times of the file do not rise and were left.");
    return {};
  }
  FrameTiming out;
  out.decisions = decisions;
  const double own_rr = stepped_rr(header.frame_times_s);
  const double unit = unit_of(own_rr, header.unit_known, out.decisions);
  if (unit == 0) return {};
  for (const double at : header.frame_times_s) out.time_s.push_back(at * unit);
  out.rr_s = given_rr > 0 ? given_rr : own_rr * unit;
  if (!(out.time_s.back() - out.time_s.front() < out.rr_s)) {
    decisions.emplace_back(
        "Warning: the frame times of the file do not fit into the given R-R interval; the "
        "phases were taken as even.");
    return {};
  }
  set_phases(out);
  tell("the frame times of the file", out);
  return out;
}

/// By the file's interval between frames, if it makes an R-R interval.
/// @param rr that interval times the frames, in the file's unit; 0 if it is not told
std::optional<FrameTiming> by_own_interval(double rr, bool unit_known, int frames, double given_rr,
                                           std::vector<std::string> decisions) {
  if (!(rr > 0)) return {};
  const double unit = unit_of(rr, unit_known, decisions);
  if (unit == 0) return {};
  rr *= unit;
  if (given_rr == 0) return even_frames(rr, frames, "the frame interval of the file", decisions);
  if (std::abs(rr - given_rr) > kSameInterval * given_rr) {
    decisions.push_back("Warning: the file's frame interval makes an R-R interval of " +
                        seconds(rr) + "; the given one was taken, its phases as even.");
  }
  return even_frames(given_rr, frames, kByRr, decisions);
}

}  // namespace

FrameTiming time_frames(const formats::ImageFileHeader& header, int frames,
                        const IngestOptions& options) {
  if (header.frame_axis == formats::FrameAxis::Other) {
    throw_invalid("its fourth axis is " + header.frame_axis_is +
                  ", not the time of a cine; export the cine's phases as one 4-D file");
  }
  if (!options.frame_times_s.empty()) return by_given_times(frames, options);

  const double given_rr = options.rr_interval_s;
  std::vector<std::string> decisions;
  if (given_rr > 0) decisions.emplace_back(kRrGiven);
  if (auto timing = by_own_times(header, frames, given_rr, decisions)) return *std::move(timing);
  const bool untold_step = header.frame_interval_s == kUntoldStep;
  const double rr = untold_step ? 0 : header.frame_interval_s * frames;
  if (auto timing = by_own_interval(rr, header.unit_known, frames, given_rr, decisions)) {
    return *std::move(timing);
  }
  if (given_rr > 0) return even_frames(given_rr, frames, kByRr, decisions);
  if (untold_step) {
    throw_invalid(
        "its frame interval of 1 is what tools write where they know no time: give the R-R "
        "interval with --rr SECONDS");
  }
  throw_invalid((rr > 0 ? "its frame interval of " + seconds(header.frame_interval_s) + " times " +
                              std::to_string(frames) + " phases is no R-R interval (0.2 to 3 s)"
                        : "it does not tell the time between its phases") +
                std::string(": give the R-R interval with --rr SECONDS"));
}

}  // namespace beatlas::ingest
