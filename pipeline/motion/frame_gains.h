#pragma once
/// Gains of frames: one frame of a slice may be brighter all over than the slice's others, where
/// its signal had not yet settled after the trigger or each image was scaled for itself. What looks
/// for a beating heart would take that for motion.

#include <vector>

#include "pipeline/core/exam.h"

namespace beatlas::motion {

/// [slice][phase] how much brighter a frame is than the middle one of its slice: the median, over
/// the half of the tissue's pixels that changes least through the beat, of what the frame shows
/// over what the pixel shows in the middle. Frames of four real exams come out alike within 1.3 %,
/// within 7 % where the images are cut to 120 mm about the heart, and a first frame 1.3 times as
/// bright within 3 % (tests/unit/motion/real_frames_test.cpp). 1 where a frame shows another image
/// than the others (noise, or nothing), in slices under 100 mm wide, or with too few pixels to
/// tell, and in images whose brightness does not count from nothing: a gain is no factor of it.
[[nodiscard]] std::vector<std::vector<double>> frame_gains(const ImageCycle<float>& images);

/// The exam without the gains of slices in which a frame's is beyond 10 %, in stack and views.
/// Exam::decisions tells of those of the stack.
[[nodiscard]] Exam with_even_frames(Exam exam);

}  // namespace beatlas::motion
