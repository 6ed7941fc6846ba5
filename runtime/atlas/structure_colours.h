#pragma once
/// The colours of the structures, once for window, report, pictures and exports.

#include <array>
#include <cstdint>
#include <string>

#include "runtime/atlas/structures.h"

namespace beatlas {

/// Red, green, blue of sRGB, 8 bit each.
using Colour = std::array<std::uint8_t, 3>;

/// On a dark ground, on grey images and as the matter of a surface. Any two are told apart also by
/// eyes that lack one kind of cones: least difference CIEDE2000 16.4 (structure_colours_test.cpp).
[[nodiscard]] Colour structure_colour(Structure structure) noexcept;

/// The same hue for lines and words on white paper, dark enough to be read there.
[[nodiscard]] Colour structure_ink(Structure structure) noexcept;

/// "#d80420".
[[nodiscard]] std::string colour_code(const Colour& colour);

}  // namespace beatlas
