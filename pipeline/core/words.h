#pragma once
/// Words that messages share.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/atlas/structures.h"

namespace beatlas {

/// Of labels, see runtime/atlas/structures.h; commands take them, too.
inline constexpr std::array<std::string_view, kLastLabel + 1> kLabelWords{
    "background",    "rv_blood", "lv_myocardium", "lv_blood",
    "rest_of_heart", "la_blood", "ra_blood",      "aorta"};

/// "1 phase", "2 phases".
template <class Count>
[[nodiscard]] std::string counted(Count count, std::string_view thing) {
  return std::to_string(count) + " " + std::string(thing) + (count == 1 ? "" : "s");
}

/// "a", "a and b", "a, b and c".
[[nodiscard]] inline std::string listed(const std::vector<std::string>& things) {
  std::string out;
  for (std::size_t n = 0; n < things.size(); ++n) {
    if (n > 0) out += n + 1 == things.size() ? " and " : ", ";
    out += things[n];
  }
  return out;
}

}  // namespace beatlas
