#pragma once
#include <atomic>
#include <functional>
#include <string>
#include <string_view>

namespace beatlas {

/// What a stage may ask of its surroundings. Stages know no file, clock or global.
class StageContext {
 public:
  /// One line for the user (stderr in the commands). May be empty.
  std::function<void(std::string_view line)> log_sink;
  /// One line that the user must see, whatever is quiet. May be empty.
  std::function<void(std::string_view line)> warn_sink;
  /// Share 0..1 of the running stage, and what it works on now (may be empty text). May be empty;
  /// is called from any thread.
  std::function<void(double share, std::string_view step)> progress_sink;
  /// Set from outside to stop; see check_cancelled.
  const std::atomic<bool>* cancel = nullptr;

  void log(std::string_view line) const {
    if (log_sink) log_sink(line);
  }
  void warn(std::string_view line) const {
    if (warn_sink) warn_sink(line);
  }
  void progress(double share, std::string_view step = {}) const {
    if (progress_sink) progress_sink(share, step);
  }
  /// The same for a part of the stage: its 0..1 is `from`..`to` of this one's, and what it works on
  /// stands behind `name`, as in "LV blood, phase 3 of 15".
  [[nodiscard]] StageContext part(double from, double to, std::string_view name = {}) const;
  /// @throws Error{Machine} if `cancel` is set.
  void check_cancelled() const;
};

}  // namespace beatlas
