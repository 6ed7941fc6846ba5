#pragma once
#include <iosfwd>

namespace beatlas::app {

/// The command `beatlas-play`: parses, runs, reports. Data goes to `out`, messages to `err`.
/// @return the exit code: 0 done, 2 usage, 3 bad input, 5 machine trouble
[[nodiscard]] int play(int argc, const char* const* argv, std::istream& in, std::ostream& out,
                       std::ostream& err);

}  // namespace beatlas::app
