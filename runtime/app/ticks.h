#pragma once
/// The file of a servo's last ticks: written when a fault freezes the recorder, or at the end;
/// played again to find out what happened.

#include <filesystem>
#include <iosfwd>
#include <string>
#include <thread>

#include "runtime/app/touch.h"
#include "runtime/atlas/atlas.h"
#include "runtime/haptics/servo.h"

namespace beatlas::app {

/// What a replay must find again, as one line: the field's SHA-256 and how it was touched.
[[nodiscard]] std::string ticks_about(const atlas::Manifest& manifest, const TouchOptions& options);

/// Writes the first fault's ticks while the session runs, in a thread of its own, so that no tick
/// waits for a disk. Without a fault: the last ticks, at `finish`.
class TickKeeper {
 public:
  TickKeeper(haptics::Servo& servo, std::filesystem::path file, std::string about);
  /// After the servo's last tick. @throws Error{Machine} if the file cannot be written whole.
  void finish();
  /// Whether what was written is of a fault.
  [[nodiscard]] bool of_fault() const { return of_fault_; }

 private:
  void write();

  haptics::Servo& servo_;
  std::filesystem::path file_;
  std::string about_;
  std::string failure_;
  bool of_fault_ = false;
  std::jthread thread_;
};

/// Ticks a recording once more and says how many came out the same.
/// @throws Error{InvalidInput} if it is no recording, is one of another package, or if a tick came
/// out otherwise.
void replay_ticks_file(const std::string& package, const std::string& file, std::ostream& out);

}  // namespace beatlas::app
