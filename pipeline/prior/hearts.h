#pragma once
/// Labels of blood by the side of the heart that it is on: these do not mix.

#include <algorithm>
#include <array>
#include <cstdint>

#include "runtime/atlas/structures.h"

namespace beatlas::prior {

inline constexpr std::array<std::uint8_t, 3> kLeftBloodLabels{kLabelLvBlood, kLabelLaBlood,
                                                              kLabelAorta};
inline constexpr std::array<std::uint8_t, 2> kRightBloodLabels{kLabelRvBlood, kLabelRaBlood};

template <class Labels>
[[nodiscard]] bool is_among(const Labels& labels, std::uint8_t label) {
  return std::find(labels.begin(), labels.end(), label) != labels.end();
}

}  // namespace beatlas::prior
