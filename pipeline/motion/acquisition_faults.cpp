#include "pipeline/motion/acquisition_faults.h"

#include <utility>

#include "pipeline/motion/frame_gains.h"
#include "pipeline/motion/slice_timing.h"

namespace beatlas::motion {

Exam without_acquisition_faults(Exam exam, const AlignOptions& options) {
  exam = with_even_frames(std::move(exam));
  if (options.slices == AlignOptions::Slices::Off) return exam;
  return with_aligned_slices(with_slices_in_step(std::move(exam)), options);
}

}  // namespace beatlas::motion
