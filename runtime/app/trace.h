#pragma once
/// What was felt tick by tick, as a CSV.

#include <cstdint>
#include <istream>
#include <string>
#include <vector>

#include "runtime/base/geometry.h"

namespace beatlas::app {

/// What was felt at one tick.
struct TraceRow {
  double time_s;
  Vec3 position_mm;  ///< workspace
  double depth_mm;
  Vec3 force_n;  ///< sent to the device, after the safety stage
  std::uint32_t buttons = 0;
  bool valid = true;     ///< what the device said of the tick
  bool stalled = false;  ///< the watchdog took the force off, and the servo began anew
};

/// CSV t_s,x_mm,y_mm,z_mm,depth_mm,fx_n,fy_n,fz_n,buttons,valid,stalled; `--device replay` plays it
/// again. A tick whose position is no number is written as not valid, at 0.
[[nodiscard]] std::string trace_csv(const std::vector<TraceRow>& trace);
/// What trace_csv wrote, row by row. @throws Error{InvalidInput} naming `name`, line and column
[[nodiscard]] std::vector<TraceRow> read_trace(std::istream& stream, const std::string& name);

}  // namespace beatlas::app
