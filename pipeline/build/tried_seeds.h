#pragma once
/// Corrections are tried before a report offers them.

#include "pipeline/build/corrections.h"

namespace beatlas::build {

/// What an alarm's seeds must do to be offered: lessen its alarm to this share of its figure, and
/// change nothing else by more than this.
inline constexpr double kAlarmLeft = 0.5;
inline constexpr double kElsewhereMl = 1;

/// Segments once more with the seeds of each alarm beside what was made by hand, and with those of
/// what is left of it, and takes them off the alarm where they do not keep what is asked above.
/// @param found what was segmented with `corrections` and `prior`
void try_seeds(const Exam& exam, const Corrections& corrections,
               const segment::SegmentOptions& options, const prior::PriorCycle* prior,
               Segmentation& found, const StageContext& context);

}  // namespace beatlas::build
