#pragma once
/// Exercises: played with a device, scored, and played once more from what was kept.

#include <atomic>
#include <cstdint>
#include <functional>
#include <iosfwd>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "runtime/app/play_options.h"
#include "runtime/device/device.h"
#include "runtime/exercise/exercise.h"
#include "runtime/haptics/servo.h"

namespace beatlas::app {

/// A part of a trial that is being played, for a picture of it.
struct ExercisePart {
  const exercise::Exercise& exercise;
  std::size_t trial = 0;         ///< from 0
  int marks = 1;                 ///< to be made
  double seconds = 0;            ///< until it ends without them
  std::vector<Vec3> places_mm;   ///< Threshold: of the surface, where one is softer; workspace
  const haptics::Servo& servo;   ///< there until `ends` returns
  const std::atomic<int>& made;  ///< marks; as long
};

/// What an exercise is played with in a window: called by the thread that plays, `marks` by every
/// tick, so it must be as quick.
struct ExerciseStage {
  std::function<std::unique_ptr<device::Device>()> mouse;  ///< the device `mouse`
  std::function<std::uint32_t()> marks;  ///< buttons that are pressed on the screen
  std::function<void(const ExercisePart&)> begins;
  std::function<void()> ends;
  std::stop_token stop;
};

/// @throws Error{InvalidInput} naming the file and the JSON path
[[nodiscard]] exercise::Exercise read_exercise(const std::string& file);

/// Plays `arguments.exercise` on the package, or goes on with it where a session of it was broken
/// off, and writes score.json and report.html when its last trial is done. What is hidden is told
/// by them alone.
/// @throws Error{InvalidInput} if the exercise cannot be read, does not fit this heart, or the
/// folder holds another session or a finished one; Error{Machine} if the device is lost or it is
/// broken off: what was played is kept
/// @param stage null: without a picture, and signals break it off
void run_exercise(const PlayArguments& arguments, std::ostream& out,
                  const ExerciseStage* stage = nullptr);

/// Plays a kept session once more, scores it, and writes score.json and report.html again.
/// @throws Error{InvalidInput} if it is of another package, not finished, or a tick comes out
/// otherwise than it was felt
void replay_exercise(const std::string& package, const std::string& folder, std::ostream& out);

}  // namespace beatlas::app
