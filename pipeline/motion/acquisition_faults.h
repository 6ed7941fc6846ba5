#pragma once
/// What the acquisition did to an exam's images and import undoes before anything looks at them.

#include "pipeline/core/exam.h"
#include "pipeline/motion/slice_shifts.h"

namespace beatlas::motion {

/// Frames made even (frame_gains.h), then slices moved back (slice_shifts.h): a shift is found in
/// means over the cycle, which a bright frame would lead.
[[nodiscard]] Exam without_acquisition_faults(Exam exam, const AlignOptions& options);

}  // namespace beatlas::motion
