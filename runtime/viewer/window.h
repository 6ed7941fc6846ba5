#pragma once
#include <optional>

#include "runtime/viewer/stills.h"

namespace beatlas::viewer {

/// Opens the window and stays until it is closed. Needs a display.
/// @return the exit code
[[nodiscard]] int show_window(const ViewOptions& options, const std::optional<OpenedHeart>& heart);

}  // namespace beatlas::viewer
