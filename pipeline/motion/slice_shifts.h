#pragma once
/// Breath-hold shifts: each slice of a stack may have been imaged with the whole anatomy moved a
/// little in its plane.

#include <vector>

#include "pipeline/core/exam.h"

namespace beatlas::motion {

/// What the images say of a stack's shifts.
struct SliceShifts {
  /// [slice] along the grid's axes i and j: anatomy at x in space is shown at x + shift.
  std::vector<Vec2> shift_mm;
  double size_mm = 0;   ///< standard deviation of a slice's shift along one axis
  double error_mm = 0;  ///< that size which the anatomy's own change from slice to slice feigns

  /// Larger than 0.3 mm and than three times what anatomy feigns, and under the 8 mm that no pause
  /// of breath exceeds: more is a comparison gone astray.
  [[nodiscard]] bool certain() const;
};

/// Where anatomy runs straight through three slices, a shift of the middle one bends it, and bends
/// it alike everywhere in the plane. Blocks of 40 mm are followed from slice to slice (least
/// squares on the mean over the cycle), a slice's bend is the one that most blocks share, and the
/// shifts are the likeliest ones with these bends: each of its own, of common size and of mean 0. A
/// shift common to all slices and one that grows evenly from slice to slice cannot be seen, and are
/// taken as none. Slices that show nothing, blank or noise, bend nothing, and stay. Fewer than 5
/// slices, or slices under 100 mm wide: no shift.
[[nodiscard]] SliceShifts find_slice_shifts(const ImageCycle<float>& images);

/// The images, in their own memory, with every slice moved back by its shift: windowed sinc over
/// six pixels, which keeps noise and edges; beyond the rim as at the rim.
/// @throws Error{InvalidInput} unless there is a shift for every slice.
[[nodiscard]] ImageCycle<float> without_shifts(ImageCycle<float> images,
                                               const std::vector<Vec2>& shift_mm);

struct AlignOptions {
  enum class Slices {
    Auto,  ///< undo shifts in place and time where they are certain
    Off,   ///< leave every slice where and when it was imaged
  };
  Slices slices = Slices::Auto;
};

/// The exam with its stack's shifts undone, where they are certain. Exam::slice_shifts_mm keeps
/// them and Exam::decisions tells them; views stay as they are.
[[nodiscard]] Exam with_aligned_slices(Exam exam, const AlignOptions& options);

}  // namespace beatlas::motion
