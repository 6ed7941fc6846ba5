#pragma once
#include <iosfwd>

namespace beatlas::viewer {

/// The command `beatlas-view`, which `beatlas-play` without --headless becomes: a window, a picture
/// or a folder of pictures. Messages go to `err`.
/// @return the exit code: 0 done, 2 usage, 3 bad input, 5 machine trouble (no display)
[[nodiscard]] int view(int argc, char** argv, std::ostream& out, std::ostream& err);

}  // namespace beatlas::viewer
