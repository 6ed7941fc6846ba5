#pragma once
/// What of the labels the prior doubts, in the figures that a doctor reads: volumes at end-diastole
/// and end-systole and the mass.

#include <string>
#include <vector>

#include "pipeline/core/shapes.h"
#include "pipeline/report/heart_figures.h"

namespace beatlas::report {

/// Expected Dice: a twentieth of the drawn hearts whose Dice is good have less (seeds 9000 to 9079,
/// `scripts/score_draws`). Good is .85 and .8 (LV at end-diastole and end-systole), .75 and .65
/// (RV), .75 (muscle).
struct ExpectedLimits {
  double lv_ed = 0.86;  ///< of the heart's outside, too
  double lv_es = 0.83;
  double rv_ed = 0.76;
  double rv_es = 0.63;
  double muscle = 0.73;

  [[nodiscard]] double of(Structure structure, bool end_systole) const;
};

/// A structure in one slice and phase, areas in mm2; see SliceBelief.
struct SliceDoubt {
  int slice = 0;
  SliceBelief belief;
};

/// What labels hold too much, or lack.
struct DoubtedVolume {
  double ml = 0;
  /// Those that hold most of it, worst first: the worst, and up to two that hold a fifth.
  std::vector<SliceDoubt> slices = {};
};

/// A structure at end-diastole or end-systole.
struct Doubt {
  Structure structure{};
  bool end_systole = false;
  int phase = 0;
  double expected_dice = 1;  ///< of about_labels
  DoubtedVolume excess;      ///< labelled and not expected
  DoubtedVolume missed;      ///< expected and not labelled
};

/// Of LV blood and RV blood at end-diastole and end-systole, of LV muscle at end-diastole, each in
/// the phase that its figure is taken from: the RV is seldom largest and smallest in the LV's
/// phases. Empty where no prior was asked.
/// @param figures of the segmentation's volumes; of a ventricle without any its LV's phases count
[[nodiscard]] std::vector<Doubt> doubts_of(const Segmentation& segmentation,
                                           const HeartFigures& figures);

/// Whether an alarm tells of the labels as a whole. The volume of a ventricle that jumps does; a
/// patch of surface does where the prior, too, expects something else in its slice, or has no say,
/// as where none was asked or a person told what the slice holds: that much of the heart's surface
/// has no edge in the image is true of most right labels.
[[nodiscard]] bool is_borne_out(const LeakAlarm& alarm, const Segmentation& segmentation,
                                const ExpectedLimits& limits);

/// "10 ml may be too much, most in slice 3 (768 mm2 labelled, 480 likely, 29 % in common) and slice
/// 4 (...)", and the same of what may be missing: the larger first, the other where it is a fifth
/// of both.
[[nodiscard]] std::string volumes_in_words(const Doubt& doubt);
/// The figures that hang on it: "ESV, EF and stroke volume of the LV".
[[nodiscard]] std::string figures_in_words(const Doubt& doubt);

}  // namespace beatlas::report
