#pragma once
#include <string>

#include "runtime/atlas/payloads.h"

namespace beatlas::formats {

/// Wavefront OBJ of one phase: vertices in workspace [mm] with nine digits, which give back each
/// float, and triangles, both in the payload's order.
[[nodiscard]] std::string obj_text(const atlas::SurfacePayload& surface, std::size_t phase);

}  // namespace beatlas::formats
