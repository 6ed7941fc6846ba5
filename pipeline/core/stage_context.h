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
  /// Share 0..1 of the running stage. May be empty.
  std::function<void(double share)> progress_sink;
  /// Set from outside to stop; see check_cancelled.
  const std::atomic<bool>* cancel = nullptr;

  void log(std::string_view line) const {
    if (log_sink) log_sink(line);
  }
  void warn(std::string_view line) const {
    if (warn_sink) warn_sink(line);
  }
  void progress(double share) const {
    if (progress_sink) progress_sink(share);
  }
  /// @throws Error{Machine} if `cancel` is set.
  void check_cancelled() const;
};

}  // namespace beatlas
