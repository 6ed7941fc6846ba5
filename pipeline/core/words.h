#pragma once
/// Words that messages share.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

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

}  // namespace beatlas
