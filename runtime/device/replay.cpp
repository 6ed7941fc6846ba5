#include "runtime/device/replay.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "runtime/base/error.h"
#include "runtime/device/csv_table.h"

namespace beatlas::device {

std::uint32_t buttons_of(double value, const std::string& name, std::size_t row) {
  constexpr double kEnd = 0x1p32;
  if (!(value >= 0 && value < kEnd && value == std::floor(value))) {
    throw_invalid(name + ": buttons must be a whole number below 2^32, but are not at row " +
                  std::to_string(row));
  }
  return static_cast<std::uint32_t>(value);
}

Recording read_recording(std::istream& stream, const std::string& name) {
  const CsvTable table = read_csv(stream, name, {"t_s", "x_mm", "y_mm", "z_mm"}, {"buttons"});
  if (table.rows.empty()) throw_invalid(name + " holds no row to play");
  Recording recording;
  for (const std::vector<double>& row : table.rows) {
    if (!recording.time_s.empty() && !(row[0] > recording.time_s.back())) {
      throw_invalid(name + ": t_s must rise from row to row, but does not at row " +
                    std::to_string(recording.time_s.size() + 1));
    }
    recording.time_s.push_back(row[0]);
    recording.position_m.emplace_back(1e-3 * Vec3(row[1], row[2], row[3]));
    if (row.size() == 4) continue;
    recording.buttons.push_back(buttons_of(row[4], name, recording.time_s.size()));
  }
  return recording;
}

ReplayDevice::ReplayDevice(Recording recording, const ReplayOptions& options)
    : recording_(std::move(recording)), options_(options) {
  const std::vector<double>& times = recording_.time_s;
  if (times.empty() || times.size() != recording_.position_m.size() ||
      (!recording_.buttons.empty() && times.size() != recording_.buttons.size()) ||
      std::adjacent_find(times.begin(), times.end(), std::greater_equal<>()) != times.end()) {
    throw_invalid("a recording needs a row at least, and times that rise");
  }
}

RunReport ReplayDevice::run(const ServoFn& servo, std::stop_token stop) {
  Pacer pacer(options_.pace, options_.rate_hz);
  const std::vector<double>& times = recording_.time_s;
  std::size_t next = 0;  // first row after the tick's time
  RunReport report;
  while (!stop.stop_requested()) {
    DeviceState state;
    state.time_s = times.front() + pacer.next();
    // A rounding of the last tick's time must not drop the last row.
    if (state.time_s > times.back() + 1e-9) break;
    while (next < times.size() && times[next] <= state.time_s) ++next;
    if (next == times.size()) {
      state.position_m = recording_.position_m.back();
    } else {
      const double length = times[next] - times[next - 1];
      const double share = (state.time_s - times[next - 1]) / length;
      const Vec3 move = recording_.position_m[next] - recording_.position_m[next - 1];
      state.position_m = recording_.position_m[next - 1] + share * move;
      state.velocity_m_s = move / length;
    }
    if (!recording_.buttons.empty()) state.buttons = recording_.buttons[next - 1];
    (void)servo(state);
    report = pacer.report();
  }
  return report;
}

}  // namespace beatlas::device
