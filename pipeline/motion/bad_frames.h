#pragma once
/// Frames that show nothing of what the others of their slice show: a broken acquisition, noise, or
/// a slice of fewer frames than the others that was filled up; and slices amid the stack that show
/// nothing at all.

#include <optional>
#include <string>
#include <vector>

#include "pipeline/core/exam.h"

namespace beatlas::motion {

struct BadFrame {
  int phase = 0;
  int k = 0;  ///< slice
};

/// Frames of one value alone, in slices that have others or lie between such slices, and frames
/// whose correlation with the mean of their slice's phases is low where that of the others is high.
/// Of the latter none where more than a quarter of a slice's phases are such, or fewer than four
/// show something.
/// @return by phase, then slice
[[nodiscard]] std::vector<BadFrame> bad_frames(const ImageCycle<float>& images);

/// The images with each bad frame drawn straight between the nearest good phases of its slice, or,
/// where it has none, between the nearest slices that have some.
/// @param bad as bad_frames tells
[[nodiscard]] ImageCycle<float> without_bad_frames(const ImageCycle<float>& images,
                                                   const std::vector<BadFrame>& bad);

/// The exam with a stack without them; none: it has none as it is.
[[nodiscard]] std::optional<Exam> without_bad_frames(const Exam& exam);

/// A sentence for each phase that has some, and one for the slices that have nothing else.
[[nodiscard]] std::vector<std::string> told(const std::vector<BadFrame>& bad, int slices,
                                            int phases);

}  // namespace beatlas::motion
