#include "runtime/app/headless.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <ctime>
#include <memory>
#include <optional>
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

/// A session while it runs: what a tick does, and what is counted of all.
class SessionRun {
 public:
  /// @param watchdog null: none  @param ended by the time or the presses that options ask for
  SessionRun(haptics::Servo& servo, const SessionOptions& options, haptics::Watchdog* watchdog,
             std::stop_source& ended, Session& session)
      : servo_(servo),
        options_(options),
        watchdog_(watchdog),
        ended_(ended),
        session_(session),
        turn_(options.workspace_from_device.linear()) {
    times_us_.reserve(options.expected_ticks);
    if (options.keep_trace) session.trace.reserve(options.expected_ticks);
  }

  /// @return the force [N] in the device's frame
  Vec3 tick(const device::DeviceState& state) {
    const Vec3 position_mm = options_.workspace_from_device * (kMmPerM * state.position_m);
    const double begin_us = thread_cpu_us();
    const haptics::Tick felt =
        servo_.tick({.time_s = state.time_s,
                     .position_mm = position_mm,
                     .valid = state.valid,
                     .orientation = Eigen::Quaterniond(turn_) * state.orientation});
    if (options_.after_tick) options_.after_tick(felt, servo_.phase());
    const double end_us = thread_cpu_us();
    const std::uint32_t buttons =
        state.buttons | (options_.more_buttons ? options_.more_buttons() : 0U);
    ++ticks_;
    if (times_us_.size() < times_us_.capacity()) {
      times_us_.push_back(static_cast<float>(end_us - begin_us));
    }
    if (session_.trace.size() < session_.trace.capacity()) {
      session_.trace.push_back(
          {state.time_s, position_mm, felt.contact.depth_mm, felt.force_n, buttons, state.valid});
    }
    contacts_ += felt.contact.touching ? 1 : 0;
    if (contacts_ > 0) count_presses(buttons);
    buttons_before_ = buttons;
    SessionReport& report = session_.report;
    limited_ += felt.status == haptics::TickStatus::Limited ? 1 : 0;
    report.faults += felt.status == haptics::TickStatus::Fault ? 1 : 0;
    report.max_model_force_n = std::max(report.max_model_force_n, felt.contact.force_n.norm());
    if (!begin_s_) begin_s_ = state.time_s;  // a recording's clock may have run before it
    if (options_.seconds > 0 && state.time_s - *begin_s_ >= options_.seconds) ended_.request_stop();
    if (watchdog_ != nullptr && !watchdog_->beat()) {
      // A stall: the force is off, and comes back by the ramp.
      servo_.restart();
      if (!session_.trace.empty()) session_.trace.back().stalled = true;
      return Vec3::Zero();
    }
    report.max_force_n = std::max(report.max_force_n, felt.force_n.norm());
    return turn_.transpose() * felt.force_n;
  }

  [[nodiscard]] std::int64_t ticks() const { return ticks_; }

  /// Puts shares and compute times into the report.
  void report_all() {
    SessionReport& report = session_.report;
    const auto all = static_cast<double>(std::max<std::int64_t>(1, ticks_));
    report.contact_share = static_cast<double>(contacts_) / all;
    report.limited_share = static_cast<double>(limited_) / all;
    report.compute = quantiles(std::move(times_us_));
  }

 private:
  void count_presses(std::uint32_t buttons) {
    presses_ += std::popcount(buttons & ~buttons_before_ & options_.mark_buttons);
    if (options_.marks_made != nullptr) {
      options_.marks_made->store(presses_, std::memory_order_relaxed);
    }
    if (options_.marks > 0 && presses_ >= options_.marks) ended_.request_stop();
  }

  haptics::Servo& servo_;
  const SessionOptions& options_;
  haptics::Watchdog* watchdog_;
  std::stop_source& ended_;
  Session& session_;
  const Eigen::Matrix3d turn_;  ///< workspace from device
  std::vector<float> times_us_;
  std::int64_t contacts_ = 0;
  std::int64_t limited_ = 0;
  std::optional<double> begin_s_;  ///< of the device's clock
  std::int64_t ticks_ = 0;
  std::uint32_t buttons_before_ = ~0U;  // a button that is down from the start was not pressed
  int presses_ = 0;
};

}  // namespace

Session run_session(device::Device& device, haptics::Servo& servo, const SessionOptions& options) {
  Session session;
  SessionReport& report = session.report;
  std::stop_source ended;
  const std::stop_callback forward(options.stop, [&ended] { ended.request_stop(); });
  std::unique_ptr<haptics::Watchdog> watchdog;
  if (options.watchdog) {
    watchdog = std::make_unique<haptics::Watchdog>([&device] { device.drop_force(); },
                                                   haptics::WatchdogOptions{});
  }
  SessionRun run(servo, options, watchdog.get(), ended, session);
  const device::ServoFn tick = [&run](const device::DeviceState& state) { return run.tick(state); };
  report.device = device.name();
  try {
    report.run = device.run(tick, ended.get_token());
  } catch (const Error& error) {
    session.lost = error;
    report.run.ticks = run.ticks();
  }
  if (watchdog) report.stalls = watchdog->stalls();
  watchdog.reset();
  run.report_all();
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
