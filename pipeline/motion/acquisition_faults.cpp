#include "pipeline/motion/acquisition_faults.h"

#include <utility>

#include "pipeline/motion/frame_gains.h"

namespace beatlas::motion {

Exam without_acquisition_faults(Exam exam, const AlignOptions& options) {
  return with_aligned_slices(with_even_frames(std::move(exam)), options);
}

}  // namespace beatlas::motion
