#pragma once
/// Where a command talks to its user: log, warnings and progress on stderr, data on stdout, wall
/// time of each stage, and the interrupt key.

#include <atomic>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/build/listener.h"
#include "pipeline/cli/progress.h"

namespace beatlas::cli {

class Console : public build::Listener {
 public:
  /// @param verbose log lines also where stderr is no terminal, and the speed table at the end
  /// Says its lines as JSON where speaks_json().
  explicit Console(bool verbose);

  /// Runs one stage with a context of its own and notes its wall and CPU time. On a terminal, or as
  /// JSON lines, its progress is shown. Interrupting sets the context's cancel flag.
  void stage(const std::string& name, const std::function<void(StageContext&)>& body) override;

  /// Always printed.
  void warn(std::string_view line) override;
  /// What the user must know that is no warning. Always printed.
  void tell(std::string_view line) override;
  /// Printed on a terminal or if verbose.
  void log(std::string_view line) override;

  /// The speed table on stderr, if verbose.
  void finish();

  /// Of the stages that have ended, in their order.
  [[nodiscard]] const std::vector<report::StageTime>& times() const override { return times_; }

  /// {"stages": [{"name", "wall_s", "cpu_s"}], "wall_s", "peak_memory_mb", "threads", "version"}
  /// @throws Error{Machine}
  void write_timing(const std::filesystem::path& file, int threads) const;

 private:
  bool verbose_;
  bool terminal_;
  Progress progress_;
  std::vector<report::StageTime> times_;
};

/// Has a write beyond a file size limit fail like one to a full disk, and makes the interrupt and
/// termination signals set the flag that Console's stages look at; the
/// second signal ends the process as usual.
void catch_interrupts();
/// That flag, for what waits outside a stage.
[[nodiscard]] const std::atomic<bool>* cancel_flag();

/// Highest resident memory of the process so far.
[[nodiscard]] double peak_memory_mb();

/// The text with '?' for control characters (a name of a file may hold some): it stays one line,
/// and commands no terminal.
[[nodiscard]] std::string one_line(std::string_view text);

/// Writes to stdout. @throws Error{Machine} if it cannot be written, for example to a full disk.
void print_data(std::string_view text);

}  // namespace beatlas::cli
