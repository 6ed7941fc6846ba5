#pragma once
/// How far labels are what a prior expected.

#include <cstddef>
#include <map>
#include <vector>

#include "runtime/atlas/structures.h"

namespace beatlas {

/// Area [mm2] of a structure in one slice: as it is labelled, as the prior expects it about the
/// heart (the sum of its probabilities), and what both have in common (that sum over what is
/// labelled).
struct SliceBelief {
  double labelled_mm2 = 0;
  double expected_mm2 = 0;
  double agreed_mm2 = 0;

  /// Dice that labels and truth would have in the mean, if the prior's probabilities were right:
  /// twice what they have in common over the sum of both; 1 where there is nothing.
  [[nodiscard]] double expected_dice() const {
    const double both = labelled_mm2 + expected_mm2;
    return both > 0 ? 2 * agreed_mm2 / both : 1;
  }
  /// Whether labels are all that is believed, as where a person told what the slice holds.
  [[nodiscard]] bool is_told() const {
    return labelled_mm2 == agreed_mm2 && expected_mm2 == agreed_mm2;
  }
};

/// [structure][phase][slice of the source's grid]; empty where no prior was asked.
using Belief = std::map<Structure, std::vector<std::vector<SliceBelief>>>;

/// Those of a phase's slices that hold labels, and the next ones: what else looks like the
/// structure, far from them, is another body.
[[nodiscard]] std::vector<std::size_t> slices_about_labels(const std::vector<SliceBelief>& slices);

/// The sum of these slices.
[[nodiscard]] SliceBelief about_labels(const std::vector<SliceBelief>& slices);

}  // namespace beatlas
