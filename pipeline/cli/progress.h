#pragma once
/// How far a stage is, shown on stderr: on a terminal one line that is written over, for other
/// programs JSON lines (schemas/progress.schema.json), else nothing.

#include <chrono>
#include <mutex>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

namespace beatlas::cli {

enum class Showing { Nothing, Line, Json };

/// May be called from any thread. One at a time in a process.
class Progress {
 public:
  explicit Progress(Showing showing);

  void begin(const std::string& stage);
  /// @param share 0..1; below what was shown already it counts as that
  /// @param step what the stage works on now; may be empty
  void show(double share, std::string_view step);
  /// @param done whether it came to its end; @param wall_s what it took
  void end(bool done, double wall_s);

  /// A line for the user; kind: "warning", "note" or "log".
  void say(std::string_view kind, std::string_view text);

 private:
  void clear();
  void write_line(std::string_view step);

  const Showing showing_;
  std::mutex mutex_;
  std::string stage_;
  std::string step_;
  double share_ = 0;
  int shown_percent_ = -1;
  bool line_is_there_ = false;
  std::chrono::steady_clock::time_point begun_;
  std::chrono::steady_clock::time_point shown_;
};

/// "8 s", "3 min", "2 h" of seconds >= 0.
[[nodiscard]] std::string duration_text(double seconds);

/// From now on all that this process says on stderr is JSON lines.
void speak_json();
[[nodiscard]] bool speaks_json();
/// {"event": "end", "exit_code": code, "text": text}, on stderr.
void say_end(int exit_code, std::string_view text);

}  // namespace beatlas::cli
