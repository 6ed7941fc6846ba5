#pragma once
#include <map>
#include <string>
#include <vector>

#include "pipeline/core/shapes.h"

namespace beatlas {

/// What segment_exam leaves behind so that after another stroke it need not begin anew, by names
/// that only segment/groundwork.h knows. Plain numbers and label images, so that a study can hold
/// it. It may be handed back with the same images and options and any seeds; what does not hold for
/// them is left aside, and the result is, bit by bit, that of a solve without it.
struct SolveMemory {
  std::map<std::string, std::vector<double>> numbers;
  std::map<std::string, LabelCycle> images;

  [[nodiscard]] bool empty() const { return numbers.empty(); }
};

}  // namespace beatlas
