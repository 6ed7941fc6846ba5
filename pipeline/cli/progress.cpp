#include "pipeline/cli/progress.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>

#include <sys/ioctl.h>
#include <unistd.h>

#include "pipeline/cli/console.h"

namespace beatlas::cli {
using nlohmann::json;
using Clock = std::chrono::steady_clock;
namespace {

constexpr double kOftenS = 0.1;     ///< a line is not written over more often
constexpr double kGuessAfterS = 1;  ///< before, what is left cannot be told
constexpr double kGuessAfterShare = 0.03;
constexpr int kUsualColumns = 80;

std::atomic<bool> json_is_spoken{false};

double seconds_since(Clock::time_point when) {
  return std::chrono::duration<double>(Clock::now() - when).count();
}

/// Negative: not known yet.
double left_s(double share, double elapsed_s) {
  if (share < kGuessAfterShare || elapsed_s < kGuessAfterS) return -1;
  return elapsed_s * (1 - share) / share;
}

int columns() {
  winsize size{};
  const bool known = ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return known ? size.ws_col : kUsualColumns;
}

/// One line at once, so that lines of several threads do not mix.
void write(const json& event) {
  const std::string line = event.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
  std::fwrite(line.data(), 1, line.size(), stderr);
  std::fflush(stderr);
}

}  // namespace

std::string duration_text(double seconds) {
  const double whole = std::ceil(seconds);
  if (whole < 100) return std::to_string(std::lround(whole)) + " s";
  if (whole < 100 * 60) return std::to_string(std::lround(whole / 60)) + " min";
  return std::to_string(std::lround(whole / 3600)) + " h";
}

void speak_json() { json_is_spoken = true; }

bool speaks_json() { return json_is_spoken; }

void say_end(int exit_code, std::string_view text) {
  write({{"event", "end"}, {"exit_code", exit_code}, {"text", text}});
}

Progress::Progress(Showing showing) : showing_(showing) {}

void Progress::begin(const std::string& stage) {
  const std::lock_guard lock(mutex_);
  stage_ = stage;
  step_.clear();
  share_ = 0;
  shown_percent_ = -1;
  begun_ = shown_ = Clock::now();
  if (showing_ == Showing::Json) write({{"event", "begin"}, {"stage", stage_}});
  if (showing_ == Showing::Line) write_line({});
}

void Progress::show(double share, std::string_view step) {
  if (showing_ == Showing::Nothing) return;
  const std::lock_guard lock(mutex_);
  share_ = std::max(share_, std::min(share, 1.0));
  const int percent = static_cast<int>(100 * share_);
  if (percent == shown_percent_ && (step == step_ || step.empty())) return;
  if (showing_ == Showing::Line && seconds_since(shown_) < kOftenS) return;
  if (!step.empty()) step_ = step;
  shown_percent_ = percent;
  if (showing_ == Showing::Line) {
    write_line(step_);
    return;
  }
  const double elapsed_s = seconds_since(begun_);
  const double left = left_s(share_, elapsed_s);
  write({{"event", "progress"},
         {"stage", stage_},
         {"step", step_},
         {"share", share_},
         {"elapsed_s", elapsed_s},
         {"left_s", left < 0 ? json(nullptr) : json(left)}});
}

void Progress::write_line(std::string_view step) {
  shown_ = Clock::now();
  std::string line = stage_ + " " + std::to_string(std::max(0, shown_percent_)) + " %";
  const double left = left_s(share_, seconds_since(begun_));
  if (left >= 0) line += ", " + duration_text(left) + " left";
  if (!step.empty()) line.append(" (").append(step).append(")");
  // A line that wraps cannot be written over.
  line = one_line(line).substr(0, static_cast<std::size_t>(std::max(1, columns() - 1)));
  std::fprintf(stderr, "\r\033[K%s", line.c_str());
  std::fflush(stderr);
  line_is_there_ = true;
}

void Progress::clear() {
  if (!line_is_there_) return;
  line_is_there_ = false;
  std::fputs("\r\033[K", stderr);
}

void Progress::end(bool done, double wall_s) {
  const std::lock_guard lock(mutex_);
  clear();
  if (showing_ == Showing::Json && done) {
    write({{"event", "done"}, {"stage", stage_}, {"wall_s", wall_s}});
  }
}

void Progress::say(std::string_view kind, std::string_view text) {
  const std::lock_guard lock(mutex_);
  if (showing_ == Showing::Json) {
    write({{"event", kind}, {"text", text}});
    return;
  }
  clear();
  const std::string line =
      std::string("beatlas: ") + (kind == "warning" ? "warning: " : "") + one_line(text) + "\n";
  std::fwrite(line.data(), 1, line.size(), stderr);
}

}  // namespace beatlas::cli
