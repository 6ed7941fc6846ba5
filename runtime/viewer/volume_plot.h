#pragma once
/// The atlas's own volume curves as a plot. Within this room alone.

#include "runtime/atlas/manifest.h"
#include "runtime/viewer/plots.h"

namespace beatlas::viewer {

/// Volumes of cavities and muscle against time, one beat, closed.
[[nodiscard]] Panel volume_panel(const atlas::Manifest& manifest);

}  // namespace beatlas::viewer
