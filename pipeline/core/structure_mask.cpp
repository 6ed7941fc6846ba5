#include "pipeline/core/structure_mask.h"

#include <algorithm>
#include <array>

namespace beatlas {

std::vector<std::uint8_t> where(const std::vector<std::uint8_t>& labels, Structure structure) {
  std::array<std::uint8_t, 256> is_in{};
  for (std::size_t label = 0; label < is_in.size(); ++label) {
    is_in[label] = label_in_structure(static_cast<std::uint8_t>(label), structure) ? 1 : 0;
  }
  std::vector<std::uint8_t> mask(labels.size());
  std::transform(labels.begin(), labels.end(), mask.begin(),
                 [&](std::uint8_t label) { return is_in[label]; });
  return mask;
}

}  // namespace beatlas
