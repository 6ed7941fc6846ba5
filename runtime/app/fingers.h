#pragma once
/// Several fingers on one heart: each its own device, thread and servo.

#include <iosfwd>
#include <string>
#include <vector>

#include "runtime/app/play_options.h"

namespace beatlas::app {

inline constexpr std::size_t kFewestFingers = 2;
inline constexpr std::size_t kMostFingers = 8;

/// What `file` (schemas/fingers.schema.json) says of each finger, over `all`, which stands for all
/// that it leaves out. A recording's name starts from the file's folder.
/// @throws Error{InvalidInput} naming file and JSON path; also if two fingers are of one device of
/// hardware
[[nodiscard]] std::vector<PlayArguments> read_fingers(const std::string& file,
                                                      const PlayArguments& all);

/// Runs them all; each one's heart begins with its own first tick, and all begin at one moment.
/// Reports each, and writes its trace beside the others: --trace t.csv to t_1.csv, t_2.csv, ...
/// @throws Error, after all have ended, of the first that was lost, or had faults
void run_fingers(const PlayArguments& arguments, std::ostream& out);

}  // namespace beatlas::app
