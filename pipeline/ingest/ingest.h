#pragma once
#include <filesystem>
#include <vector>

#include "pipeline/core/exam.h"
#include "pipeline/core/stage_context.h"

namespace beatlas::ingest {

struct IngestOptions {
  /// [s] 0.2..3, or 0 for the source's. Sets the exam's R-R interval; those of DICOM slices
  /// that have their own keep their proportions. Recorded times that fill a slice's own interval
  /// stretch with it; others stay and must lie within it.
  double rr_interval_s = 0;
  /// [s] when each frame of a slice was taken, ascending, one a frame in the order of the cycle;
  /// empty: the source's. They replace whatever times the source names, of every slice; a view
  /// with another number of frames keeps its own.
  std::vector<double> frame_times_s = {};
  /// 2..200 common phases to resample to, or 0 for as many as the stack's slices have.
  int phases = 0;
  /// Which of several patients or studies in one folder, from 1 as the message that asks lists
  /// them; 0: there is only one.
  int exam = 0;
  /// Series numbers to take images from; empty: all.
  std::vector<int> series = {};
  /// Which of the possible stacks, from 1 as `decisions` lists them; 0: the best one.
  int stack = 0;
};

/// Reads DICOM folders and files (a whole mixed exam, each slice its own series, any order, any
/// file names), or image files: one 4-D NIfTI, NRRD or MetaImage file, or 3-D ones, a phase each,
/// named one by one or all the image files of a folder, in the natural order of their names.
///
/// DICOM: classic and multi-frame objects of every transfer syntax but video. A file that is cut
/// short, or an MR image whose spacing, position or direction is no geometry, is an error wherever
/// in the exam it lies; colour, reports and DICOMDIR are left; copies count once.
/// Exams: images of one patient and study (or frame of reference). Of several, `exam` chooses; not
/// said, the only study of one patient that holds a stack is taken, and between patients it is an
/// error that lists them by number, in counts.
/// Stack: that with most parallel slices (at least 3), then of one contrast, one series, with most
/// phases; cines in which every image has a trigger time of its own and which have 8 phases or more
/// come first, flow and perfusion last. `decisions` lists the possible stacks and why the first
/// won; `stack` takes another, `series` leaves only images of these numbers.
/// Geometry comes from ImagePositionPatient, ImageOrientationPatient and PixelSpacing alone.
/// The grid's axes are row, column, row x column (determinant +1), k growing along the last. Slices
/// have their own R-R interval and frame times (see slice_timing.h for which attribute is trusted);
/// each is resampled to common phases p/N of its R-R by a periodic cubic, copied where a frame lies
/// on the phase; a gap that was never imaged is bridged by it and told. Fewer than 8 frames are
/// assigned, not blended: a blend of two far phases shows two hearts.
/// Views: other cines of one or two parallel slices, one Cine a slice, the same number of phases.
///
/// Image files: voxel order is the file's, but that the axis of the slices is made the third where
/// it is another (slice_axis.h); the grid LPS of either handedness; no views. Frames are even in
/// the R-R interval (R-R = frames x interval) unless the file names the time of each or
/// `frame_times_s` does: then they are resampled as those of DICOM. A file that tells no time, as
/// no list of files does, needs `rr_interval_s` or `frame_times_s`; one that says that its fourth
/// axis is no time is refused. A folder that holds DICOM too is read as DICOM.
///
/// What was chosen, what was left and why is in Exam::decisions; series numbers and counts appear
/// there, never text from the files. Messages show the sources as they were typed, and what lies
/// below them without what may be identity in it (see shown_path.h).
/// @throws Error{InvalidInput} with the file or folder and the reason; Error{Machine} if cancelled.
[[nodiscard]] Exam read_exam(const std::vector<std::filesystem::path>& sources,
                             const IngestOptions& options, StageContext& context);

}  // namespace beatlas::ingest
