#pragma once
#include <iosfwd>

namespace beatlas::app {

/// Whether the words ask for a picture: a window, --screenshot or --record, and not for a session
/// without one, a report or help.
[[nodiscard]] bool wants_picture(int argc, const char* const* argv);

/// This process becomes `beatlas-view`, which lies beside it, with the same words: beatlas-play
/// itself links no drawing library.
/// @return only if that cannot be: the exit code, 2 where this build has no viewer
[[nodiscard]] int become_viewer(char** argv, std::ostream& err);

}  // namespace beatlas::app
