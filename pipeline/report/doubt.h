#pragma once
/// What of the labels the prior doubts, in the figures that a doctor reads: volumes at end-diastole
/// and end-systole and the mass.

#include <string>
#include <vector>

#include "pipeline/core/shapes.h"

namespace beatlas::report {

/// A structure in one slice and phase, areas in mm2; see SliceBelief.
struct SliceDoubt {
  int slice = 0;
  SliceBelief belief;

  /// What is labelled and not expected, and the other way round.
  [[nodiscard]] double doubted_mm2() const {
    return belief.labelled_mm2 + belief.expected_mm2 - 2 * belief.agreed_mm2;
  }
};

/// A structure at end-diastole or end-systole.
struct Doubt {
  Structure structure{};
  bool end_systole = false;
  int phase = 0;
  double expected_dice = 1;  ///< of about_labels
  double excess_ml = 0;      ///< labelled and not expected
  double missed_ml = 0;      ///< expected and not labelled
  /// Those that hold most of the doubt, worst first: the worst, and up to two that hold a fifth.
  std::vector<SliceDoubt> slices;
};

/// Of LV blood and RV blood at end-diastole and end-systole, of LV muscle at end-diastole. Empty
/// where no prior was asked.
[[nodiscard]] std::vector<Doubt> doubts_of(const Segmentation& segmentation);

/// "slice 3 (768 mm2 labelled, 480 likely, 29 % in common) and slice 4 (...)".
[[nodiscard]] std::string slices_in_words(const Doubt& doubt);
/// The figures that hang on it: "ESV, EF and stroke volume of the LV".
[[nodiscard]] std::string figures_in_words(const Doubt& doubt);

}  // namespace beatlas::report
