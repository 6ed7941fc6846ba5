#pragma once
/// When the images of a file other than DICOM were taken, as shares of the R-R interval.

#include <string>
#include <vector>

#include "pipeline/formats/image_file.h"
#include "pipeline/ingest/ingest.h"

namespace beatlas::ingest {

struct FrameTiming {
  double rr_s = 0;
  std::vector<double> time_s;  ///< one a frame, ascending; made up from the order if nothing tells
  std::vector<double> phases;  ///< one a frame, ascending from 0, below 1
  bool even = true;            ///< phase p is p / frames
  std::vector<std::string> decisions;
};

/// In this order of trust: the times in `options`, those the file names one by one, its interval.
/// Without any, the R-R interval in `options` and even frames. Times that an R-R interval in
/// `options` cannot hold give way to even frames, as does an interval that contradicts it. Numbers
/// without a unit, or that make no R-R interval as seconds, are tried as milliseconds, with a
/// warning; an interval of 1, in seconds or without a unit, is what
/// tools write where they know no time, and tells nothing. The decisions always tell which time was
/// believed and the R-R interval that it makes.
/// @param frames at least 2
/// @throws Error{InvalidInput} with a clause that follows "FILE: ": the frames are told to be no
///         phases, the given times are none, or nothing tells the R-R interval
[[nodiscard]] FrameTiming time_frames(const formats::ImageFileHeader& header, int frames,
                                      const IngestOptions& options);

}  // namespace beatlas::ingest
