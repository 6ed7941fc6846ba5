#include "pipeline/core/belief.h"

namespace beatlas {

std::vector<std::size_t> slices_about_labels(const std::vector<SliceBelief>& slices) {
  std::vector<std::size_t> out;
  const auto labelled = [&](std::size_t k) { return slices[k].labelled_mm2 > 0; };
  for (std::size_t k = 0; k < slices.size(); ++k) {
    if (labelled(k) || (k > 0 && labelled(k - 1)) || (k + 1 < slices.size() && labelled(k + 1))) {
      out.push_back(k);
    }
  }
  return out;
}

SliceBelief about_labels(const std::vector<SliceBelief>& slices) {
  SliceBelief out;
  for (const std::size_t k : slices_about_labels(slices)) {
    out.labelled_mm2 += slices[k].labelled_mm2;
    out.expected_mm2 += slices[k].expected_mm2;
    out.agreed_mm2 += slices[k].agreed_mm2;
  }
  return out;
}

}  // namespace beatlas
