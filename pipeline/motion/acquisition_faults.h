#pragma once
/// What the acquisition did to an exam's images and import undoes before anything looks at them.

#include "pipeline/core/exam.h"
#include "pipeline/motion/slice_shifts.h"

namespace beatlas::motion {

/// Frames made even (frame_gains.h), slices put in step (slice_timing.h), then moved back
/// (slice_shifts.h): a bright frame looks like motion, and leads the means over the cycle in which
/// a shift is found.
[[nodiscard]] Exam without_acquisition_faults(Exam exam, const AlignOptions& options);

}  // namespace beatlas::motion
