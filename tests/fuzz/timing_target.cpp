// Times as scanners fill them, and what is made of them: numbers of any bits.
#include <algorithm>
#include <cmath>

#include "pipeline/ingest/even_positions.h"
#include "pipeline/ingest/frame_timing.h"
#include "pipeline/ingest/phase_resampling.h"
#include "pipeline/ingest/slice_timing.h"
#include "tests/fuzz/fuzz_target.h"

namespace beatlas::fuzz {
namespace {

std::string numbers(std::uint8_t kind, std::uint8_t what, const std::vector<double>& values) {
  std::string out{static_cast<char>(kind), static_cast<char>(what)};
  out.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double));
  return out;
}

void check_phases(const std::vector<double>& phases) {
  for (const double phase : phases) require(phase >= 0 && phase < 1);
  std::vector<double> sorted = phases;
  std::sort(sorted.begin(), sorted.end());
  if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) return;
  for (const int count : {2, 25}) {
    for (const auto& taps : ingest::resample_phases(phases, count)) {
      double sum = 0;
      for (int tap = 0; tap < taps.count; ++tap) {
        const auto at = static_cast<std::size_t>(tap);
        require(taps.frame[at] >= 0 && taps.frame[at] < static_cast<int>(phases.size()));
        sum += taps.weight[at];
      }
      require(taps.count >= 1 && taps.count <= 4);
      require(std::abs(sum - 1) < 1e-3);
    }
  }
}

void stamps(std::uint8_t what, Values& values) {
  std::vector<ingest::FrameStamp> out;
  while (!values.empty() && out.size() < 300) {
    ingest::FrameStamp stamp;
    if (what & 1) stamp.trigger_ms = values.take<double>();
    if (what & 2) stamp.rr_ms = values.take<double>();
    if (what & 4) stamp.frame_time_ms = values.take<double>();
    if (what & 8) stamp.temporal_position = values.take<double>();
    if (what & 16) stamp.instance = values.take<double>();
    if (what & 32) stamp.elapsed_ms = values.take<double>();
    if (what & 64) stamp.acquisition_s = values.take<double>();
    if (what & 128) stamp.content_s = values.take<double>();
    if (what == 0) (void)values.take<double>();
    // The scan hands on finite numbers alone.
    for (const auto member :
         {&ingest::FrameStamp::trigger_ms, &ingest::FrameStamp::rr_ms,
          &ingest::FrameStamp::frame_time_ms, &ingest::FrameStamp::temporal_position,
          &ingest::FrameStamp::elapsed_ms, &ingest::FrameStamp::acquisition_s,
          &ingest::FrameStamp::content_s, &ingest::FrameStamp::instance}) {
      if (stamp.*member && !std::isfinite(*(stamp.*member))) (stamp.*member).reset();
    }
    out.push_back(stamp);
  }
  const auto timing = ingest::time_slice(out);
  if (!timing) return;
  require(timing->order.size() == timing->time_s.size() && timing->order.size() >= 2);
  for (const int index : timing->order) require(index >= 0 && index < static_cast<int>(out.size()));
  check_phases(ingest::phases_of(*timing, 0.8));
}

void frames(std::uint8_t what, Values& values) {
  formats::ImageFileHeader header;
  ingest::IngestOptions options;
  header.frame_axis = formats::FrameAxis::Untold;
  header.unit_known = (what & 1) != 0;
  header.frame_interval_s = std::abs(values.take<double>());
  if (what & 2) options.rr_interval_s = 0.2 + values.take<std::uint8_t>() / 100.0;
  auto& times = (what & 4) != 0 ? options.frame_times_s : header.frame_times_s;
  while (!values.empty() && times.size() < 300) times.push_back(values.take<double>());
  const int count = std::max(2, static_cast<int>(times.size()));
  const auto timing = ingest::time_frames(header, count, options);
  require(static_cast<int>(timing.phases.size()) == count);
  require(timing.rr_s >= ingest::kLeastRrS && timing.rr_s <= ingest::kMostRrS);
  check_phases(timing.phases);
}

}  // namespace

std::vector<std::string> seeds() {
  std::vector<double> even;
  std::vector<double> stamped;
  for (int p = 0; p < 20; ++p) {
    even.push_back(p * 0.04);
    stamped.insert(stamped.end(), {p * 40.0, 800.0});
  }
  return {numbers(0, 3, stamped), numbers(0, 1, even),  numbers(0, 16, even),
          numbers(0, 32, even),   numbers(0, 64, even), numbers(0, 130, stamped),
          numbers(1, 1, even),    numbers(1, 7, even),  numbers(2, 0, {0, 8, 16, 24, 33})};
}
std::vector<std::string> tokens() {
  return {std::string(8, '\0'), std::string("\0\0\0\0\0\0\xf8\x7f", 8),
          std::string("\0\0\0\0\0\0\x59\x40", 8)};
}
}  // namespace beatlas::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace beatlas;
  fuzz::Values values(data, size);
  const auto kind = values.take<std::uint8_t>();
  const auto what = values.take<std::uint8_t>();
  fuzz::only_errors([&] {
    if (kind % 3 == 0) {
      fuzz::stamps(what, values);
    } else if (kind % 3 == 1) {
      fuzz::frames(what, values);
    } else {
      std::vector<double> positions;
      while (!values.empty() && positions.size() < 300) {
        const double at = values.take<double>();
        if (std::abs(at) < 1e6) positions.push_back(at);
      }
      // Places of a plane are apart: images nearer than this are of one place.
      std::sort(positions.begin(), positions.end());
      positions.erase(std::unique(positions.begin(), positions.end(),
                                  [](double a, double b) { return b - a < 1e-3; }),
                      positions.end());
      const auto stack = ingest::find_even_stack(positions);
      fuzz::require(stack.members.size() >= 3 && stack.spacing_mm > 0);
    }
  });
  return 0;
}
