#pragma once
#include <string>
#include <vector>

#include "pipeline/core/grid.h"

namespace beatlas {

/// ECG-gated images of one stack of parallel slices (or of one view: one slice).
/// Phases are uniform in the R-R interval: phase p stands for time p / N of it. Slice index k
/// grows along +k of the grid; the grid is in patient LPS [mm], any handedness.
struct Cine {
  ImageCycle<float> images;
  double rr_interval_s = 0;           ///< mean over slices, > 0
  std::vector<double> frame_times_s;  ///< of the source's frames, ascending, as recorded; of as
                                      ///< many as there are phases unless those were resampled

  [[nodiscard]] const Grid& grid() const { return images.grid; }
  [[nodiscard]] int phase_count() const { return images.phase_count(); }
  [[nodiscard]] double frame_interval_s() const {
    return rr_interval_s / (phase_count() > 0 ? phase_count() : 1);
  }
};

/// What an examination gave: the stack to build from and the views beside it.
struct Exam {
  Cine stack;
  std::vector<Cine> views;             ///< long-axis and other cine views; may be empty
  std::vector<std::string> decisions;  ///< what was chosen, left and why; one sentence each
  /// [slice of the stack] along its axes i and j: how far its breath-hold had moved the anatomy,
  /// before it was moved back (see motion/slice_shifts.h); empty: nothing was moved.
  std::vector<Vec2> slice_shifts_mm;
  /// [slice of the stack] how many phases later than the others it showed the beat, before its
  /// frames were moved round it (see motion/slice_timing.h); empty: none was.
  std::vector<int> slice_lags;
  std::string source_format;  ///< "dicom", "nifti", "nrrd" or "metaimage"
  /// Of the phantom that all images of the stack say they were made from (see phantom_mark.h);
  /// empty: they were made from none, or do not say.
  std::string phantom_identity;
  std::string shown_source;  ///< the source as messages may show it; never stored
};

}  // namespace beatlas
