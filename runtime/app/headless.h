#pragma once
#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "runtime/app/trace.h"
#include "runtime/base/error.h"
#include "runtime/device/device.h"
#include "runtime/field/field_query.h"
#include "runtime/haptics/servo.h"

namespace beatlas::app {

/// Compute time of a tick [us], thread CPU time, the clock's own cost included.
struct ComputeTime {
  double p50_us = 0;
  double p99_us = 0;
  double p999_us = 0;
  double max_us = 0;
};

struct SessionReport {
  std::string device;
  device::RunReport run;
  ComputeTime compute;
  double max_force_n = 0;        ///< after the safety stage
  double max_model_force_n = 0;  ///< before it
  double contact_share = 0;      ///< of the ticks, 0..1
  double limited_share = 0;      ///< ticks whose force the safety stage made smaller, 0..1
  std::int64_t faults = 0;       ///< ticks with zero force by a fault
  std::int64_t stalls = 0;       ///< times the watchdog took the force off
};

struct Session {
  SessionReport report;
  std::vector<TraceRow> trace;  ///< one row a tick if it was asked for
  std::optional<Error> lost;    ///< what the device said when it failed; the rest is of before
};

struct SessionOptions {
  /// To reserve; further ticks are counted but neither traced nor in the compute times, so that no
  /// tick allocates.
  std::size_t expected_ticks = 0;
  bool keep_trace = false;
  /// Where the device's point is, mm from mm; rigid. A simulated hand's own frame is the workspace.
  Affine workspace_from_device = Affine::Identity();
  double seconds = 0;         ///< [s] > 0: ends a device that would never end; 0: it ends by itself
  bool watchdog = false;      ///< in real time: take the force off when a tick hangs
  std::stop_token stop = {};  ///< ends it at any time
  /// > 0: as many presses of one of `mark_buttons` after the first contact end it.
  int marks = 0;
  std::uint32_t mark_buttons = 0;
  /// Buttons that are pressed elsewhere than on the device, asked every tick; none: none.
  std::function<std::uint32_t()> more_buttons = nullptr;
  std::atomic<int>* marks_made = nullptr;  ///< how many presses there were, for another thread
  /// Called after every tick, with the heart's phase (0..1); must be as quick as a tick is.
  std::function<void(const haptics::Tick&, double phase)> after_tick = nullptr;
};

/// Runs `servo` on `device` until the device ends.
[[nodiscard]] Session run_session(device::Device& device, haptics::Servo& servo,
                                  const SessionOptions& options);

/// See schemas/play.schema.json.
[[nodiscard]] nlohmann::json session_json(const SessionReport& report);
/// A few lines for people; ends with a newline.
[[nodiscard]] std::string session_text(const SessionReport& report);

}  // namespace beatlas::app
