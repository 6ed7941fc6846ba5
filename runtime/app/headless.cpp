#include "runtime/app/headless.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <ctime>
#include <memory>
#include <sstream>
#include <stop_token>

#include "runtime/base/error.h"
#include "runtime/haptics/watchdog.h"

namespace beatlas::app {
namespace {

double thread_cpu_us() noexcept {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

ComputeTime quantiles(std::vector<float> times_us) {
  ComputeTime out;
  if (times_us.empty()) return out;
  std::sort(times_us.begin(), times_us.end());
  const auto at = [&](double share) {  // nearest rank
    const double rank = std::ceil(share * static_cast<double>(times_us.size()));
    return static_cast<double>(times_us[static_cast<std::size_t>(std::max(rank, 1.0)) - 1]);
  };
  out.p50_us = at(0.5);
  out.p99_us = at(0.99);
  out.p999_us = at(0.999);
  out.max_us = at(1);
  return out;
}

}  // namespace

Session run_session(device::Device& device, haptics::Servo& servo, const SessionOptions& options) {
  Session session;
  SessionReport& report = session.report;
  std::vector<float> times_us;
  times_us.reserve(options.expected_ticks);
  if (options.keep_trace) session.trace.reserve(options.expected_ticks);
  std::int64_t contacts = 0;
  std::int64_t limited = 0;
  std::int64_t ticks = 0;
  std::stop_source ended;
  const std::stop_callback forward(options.stop, [&ended] { ended.request_stop(); });
  std::unique_ptr<haptics::Watchdog> watchdog;
  if (options.watchdog) {
    watchdog = std::make_unique<haptics::Watchdog>([&device] { device.drop_force(); },
                                                   haptics::WatchdogOptions{});
  }
  std::uint32_t buttons_before = ~0U;  // a button that is down from the start was not pressed
  int presses = 0;
  const Eigen::Matrix3d turn = options.workspace_from_device.linear();
  const device::ServoFn tick = [&](const device::DeviceState& state) -> Vec3 {
    const Vec3 position_mm = options.workspace_from_device * (kMmPerM * state.position_m);
    const double begin_us = thread_cpu_us();
    const haptics::Tick felt =
        servo.tick({.time_s = state.time_s,
                    .position_mm = position_mm,
                    .valid = state.valid,
                    .orientation = Eigen::Quaterniond(turn) * state.orientation});
    if (options.after_tick) options.after_tick(felt, servo.phase());
    const double end_us = thread_cpu_us();
    const std::uint32_t buttons =
        state.buttons | (options.more_buttons ? options.more_buttons() : 0U);
    ++ticks;
    if (times_us.size() < times_us.capacity()) {
      times_us.push_back(static_cast<float>(end_us - begin_us));
    }
    if (session.trace.size() < session.trace.capacity()) {
      session.trace.push_back(
          {state.time_s, position_mm, felt.contact.depth_mm, felt.force_n, buttons, state.valid});
    }
    contacts += felt.contact.touching ? 1 : 0;
    if (contacts > 0) {
      presses += std::popcount(buttons & ~buttons_before & options.mark_buttons);
      if (options.marks_made != nullptr) {
        options.marks_made->store(presses, std::memory_order_relaxed);
      }
      if (options.marks > 0 && presses >= options.marks) ended.request_stop();
    }
    buttons_before = buttons;
    limited += felt.status == haptics::TickStatus::Limited ? 1 : 0;
    report.faults += felt.status == haptics::TickStatus::Fault ? 1 : 0;
    report.max_model_force_n = std::max(report.max_model_force_n, felt.contact.force_n.norm());
    if (options.seconds > 0 && state.time_s >= options.seconds) ended.request_stop();
    if (watchdog && !watchdog->beat()) {  // a stall: the force is off, and comes back by the ramp
      servo.restart();
      if (!session.trace.empty()) session.trace.back().stalled = true;
      return Vec3::Zero();
    }
    report.max_force_n = std::max(report.max_force_n, felt.force_n.norm());
    return turn.transpose() * felt.force_n;
  };
  report.device = device.name();
  try {
    report.run = device.run(tick, ended.get_token());
  } catch (const Error& error) {
    session.lost = error;
    report.run.ticks = ticks;
  }
  if (watchdog) report.stalls = watchdog->stalls();
  watchdog.reset();
  const auto all = static_cast<double>(std::max<std::int64_t>(1, ticks));
  report.contact_share = static_cast<double>(contacts) / all;
  report.limited_share = static_cast<double>(limited) / all;
  report.compute = quantiles(std::move(times_us));
  return session;
}

nlohmann::json session_json(const SessionReport& report) {
  return {{"device", report.device},
          {"ticks", report.run.ticks},
          {"late_ticks", report.run.late_ticks},
          {"worst_late_ms", 1e3 * report.run.worst_late_s},
          {"compute_us",
           {{"p50", report.compute.p50_us},
            {"p99", report.compute.p99_us},
            {"p99_9", report.compute.p999_us},
            {"max", report.compute.max_us}}},
          {"max_force_n", report.max_force_n},
          {"max_model_force_n", report.max_model_force_n},
          {"contact_share", report.contact_share},
          {"limited_share", report.limited_share},
          {"faults", report.faults},
          {"stalls", report.stalls}};
}

std::string session_text(const SessionReport& report) {
  std::ostringstream text;
  text.precision(3);
  text << report.device << " device: " << report.run.ticks << " ticks, " << report.run.late_ticks
       << " late (worst " << 1e3 * report.run.worst_late_s << " ms)\n"
       << "compute time a tick: p50 " << report.compute.p50_us << ", p99 " << report.compute.p99_us
       << ", p99.9 " << report.compute.p999_us << ", max " << report.compute.max_us << " us\n"
       << "largest force " << report.max_force_n << " N (model " << report.max_model_force_n
       << " N), in contact " << 100 * report.contact_share << " %, limited "
       << 100 * report.limited_share << " %, " << report.faults << " faults, " << report.stalls
       << " stalls\n";
  return text.str();
}

}  // namespace beatlas::app
