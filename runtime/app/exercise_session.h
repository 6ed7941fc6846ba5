#pragma once
/// Exercises: played with a device, scored, and played once more from what was kept.

#include <iosfwd>
#include <string>

#include "runtime/app/play_options.h"

namespace beatlas::app {

/// Plays `arguments.exercise` on the package, or goes on with it where a session of it was broken
/// off, and writes score.json and report.html when its last trial is done. What is hidden is told
/// by them alone.
/// @throws Error{InvalidInput} if the exercise cannot be read, does not fit this heart, or the
/// folder holds another session or a finished one; Error{Machine} if the device is lost: what was
/// played is kept
void run_exercise(const PlayArguments& arguments, std::ostream& out);

/// Plays a kept session once more, scores it, and writes score.json and report.html again.
/// @throws Error{InvalidInput} if it is of another package, not finished, or a tick comes out
/// otherwise than it was felt
void replay_exercise(const std::string& package, const std::string& folder, std::ostream& out);

}  // namespace beatlas::app
