#include "runtime/atlas/structure_colours.h"

#include <cstdio>

namespace beatlas {
namespace {

struct Tints {
  Colour colour;
  Colour ink;
};

// In the order of kAllStructures. Found by a search for the largest least difference of any two, as
// seen by all eyes, among colours whose hues a reader expects: blood of the left side red and
// magenta, of the right side blue and cyan.
constexpr std::array<Tints, kAllStructures.size()> kTints{{
    {{241, 237, 189}, {61, 62, 0}},    // heart
    {{216, 4, 32}, {162, 33, 51}},     // lv_blood
    {{29, 94, 251}, {0, 50, 236}},     // rv_blood
    {{94, 178, 135}, {77, 128, 94}},   // lv_myocardium
    {{178, 101, 145}, {224, 0, 139}},  // la_blood
    {{27, 239, 255}, {0, 69, 77}},     // ra_blood
    {{241, 161, 21}, {142, 110, 12}},  // aorta
}};

}  // namespace

Colour structure_colour(Structure structure) noexcept {
  return kTints[static_cast<std::size_t>(structure)].colour;
}

Colour structure_ink(Structure structure) noexcept {
  return kTints[static_cast<std::size_t>(structure)].ink;
}

std::string colour_code(const Colour& colour) {
  std::array<char, 8> text{};
  std::snprintf(text.data(), text.size(), "#%02x%02x%02x", colour[0], colour[1], colour[2]);
  return text.data();
}

}  // namespace beatlas
