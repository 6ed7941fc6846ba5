#include "pipeline/cli/console.h"

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>

#include <nlohmann/json.hpp>
#include <sys/resource.h>
#include <unistd.h>

#include "pipeline/build/version.h"
#include "pipeline/core/parallel.h"
#include "pipeline/study/files.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
namespace {

std::atomic<bool> cancel_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");

extern "C" void request_cancel(int signal) {
  cancel_requested.store(true, std::memory_order_relaxed);
  std::signal(signal, SIG_DFL);
}

double cpu_s() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double wall_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

void catch_interrupts() {
  std::signal(SIGINT, request_cancel);
  std::signal(SIGTERM, request_cancel);
  std::signal(SIGXFSZ, SIG_IGN);
  set_stop_flag(&cancel_requested);
}

const std::atomic<bool>* cancel_flag() { return &cancel_requested; }

double peak_memory_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;  // Linux counts KiB
}

std::string one_line(std::string_view text) {
  std::string out;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const auto c = static_cast<unsigned char>(text[at]);
    const auto next = static_cast<unsigned char>(at + 1 < text.size() ? text[at + 1] : ' ');
    const bool in_two_bytes = c == 0xC2 && next >= 0x80 && next < 0xA0;  // U+0080..9F in UTF-8
    if (in_two_bytes) ++at;
    out += c < ' ' || c == 0x7F || in_two_bytes ? '?' : static_cast<char>(c);
  }
  return out;
}

void print_data(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0) {
    throw Error(ErrorCode::Machine, "the output cannot be written to stdout");
  }
}

Console::Console(bool verbose)
    : verbose_(verbose),
      terminal_(isatty(STDERR_FILENO) == 1),
      progress_(speaks_json() ? Showing::Json
                : terminal_   ? Showing::Line
                              : Showing::Nothing) {}

void Console::stage(const std::string& name, const std::function<void(StageContext&)>& body) {
  StageContext context;
  context.cancel = &cancel_requested;
  context.log_sink = [this, &name](std::string_view line) { log(name + ": " + std::string(line)); };
  context.warn_sink = [this, &name](std::string_view line) {
    warn(name + ": " + std::string(line));
  };
  context.progress_sink = [this](double share, std::string_view step) {
    progress_.show(share, step);
  };
  progress_.begin(name);
  const double wall = wall_s();
  const double cpu = cpu_s();
  try {
    context.check_cancelled();
    body(context);
  } catch (...) {
    progress_.end(false, wall_s() - wall);
    throw;
  }
  times_.push_back({name, wall_s() - wall, cpu_s() - cpu});
  progress_.end(true, times_.back().wall_s);
}

void Console::warn(std::string_view line) { progress_.say("warning", line); }

void Console::tell(std::string_view line) { progress_.say("note", line); }

void Console::log(std::string_view line) {
  if (terminal_ || verbose_) progress_.say("log", line);
}

void Console::finish() {
  if (!verbose_ || speaks_json()) return;
  std::fputs(report::speed_table(times_, peak_memory_mb()).c_str(), stderr);
}

void Console::write_timing(const std::filesystem::path& file, int threads) const {
  nlohmann::json stages = nlohmann::json::array();
  double total = 0;
  for (const report::StageTime& time : times_) {
    stages.push_back({{"name", time.stage}, {"wall_s", time.wall_s}, {"cpu_s", time.cpu_s}});
    total += time.wall_s;
  }
  study::write_json(file, {{"stages", stages},
                           {"wall_s", total},
                           {"peak_memory_mb", peak_memory_mb()},
                           {"threads", threads},
                           {"version", build::kVersion}});
}

}  // namespace beatlas::cli
