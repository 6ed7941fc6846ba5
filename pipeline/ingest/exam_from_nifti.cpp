#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "pipeline/core/parallel.h"
#include "pipeline/formats/nifti.h"
#include "pipeline/ingest/exam_sources.h"
#include "pipeline/ingest/phase_resampling.h"
#include "pipeline/ingest/slice_timing.h"
#include "runtime/base/error.h"

namespace beatlas::ingest {
namespace {

bool plausible(double rr_s) { return rr_s >= kLeastRrS && rr_s <= kMostRrS; }

std::string seconds(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.4g s", value);
  return text;
}

/// Seconds between frames, 0 if the file does not tell; adds what was odd.
double interval_s(const formats::NiftiHeader& header, int phases,
                  std::vector<std::string>& decisions) {
  const double step = header.frame_interval_s;
  const double rr = step * phases;
  // 1 without a unit is what tools write where they know no time.
  if (step <= 0 || (!header.has_time_axis && step == 1)) return 0;
  if (plausible(rr)) {
    if (!header.has_time_axis) {
      decisions.push_back("Warning: the file names no unit of time, seconds were taken.");
    }
    return step;
  }
  if (plausible(rr * 1e-3)) {
    decisions.push_back(
        "Warning: the frame interval makes an R-R interval only as milliseconds, these were "
        "taken.");
    return step * 1e-3;
  }
  return 0;
}

void resample(ImageCycle<float>& images, int phases) {
  std::vector<double> at;
  for (int p = 0; p < images.phase_count(); ++p) {
    at.push_back(static_cast<double>(p) / images.phase_count());
  }
  const auto taps = resample_phases(at, phases);
  std::vector<std::vector<float>> out(taps.size());
  parallel_for(taps.size(), [&](std::size_t p) { out[p] = blend(images.phases, taps[p]); });
  images.phases = std::move(out);
}

}  // namespace

Exam exam_from_nifti(const std::filesystem::path& file, const IngestOptions& options,
                     StageContext& context) {
  Exam exam;
  exam.source_format = "nifti";
  formats::NiftiHeader header;
  exam.stack.images = formats::read_nifti(file, &header);
  context.check_cancelled();
  try {
    ImageCycle<float>& images = exam.stack.images;
    const int frames = images.phase_count();
    if (frames < 2) {
      throw_invalid("it holds one image only: a 4-D file with several phases is needed");
    }
    if (images.grid.size[2] < 3) {
      throw_invalid("it holds " + std::to_string(images.grid.size[2]) +
                    " parallel slices, at least 3 are needed");
    }
    if (!header.note.empty()) exam.decisions.push_back("Warning: " + header.note);
    const double step = interval_s(header, frames, exam.decisions);
    if (step == 0 && options.rr_interval_s <= 0) {
      throw_invalid(header.frame_interval_s > 0
                        ? "its frame interval of " + seconds(header.frame_interval_s) + " times " +
                              std::to_string(frames) +
                              " frames is no R-R interval (0.2 to 3 s): give the R-R interval"
                        : "it has no time axis (pixdim[4]): give the R-R interval");
    }
    exam.stack.rr_interval_s = options.rr_interval_s > 0 ? options.rr_interval_s : step * frames;
    if (options.rr_interval_s > 0) {
      exam.decisions.push_back("The R-R interval was given, not taken from the file.");
    }
    const double recorded = step > 0 ? step : exam.stack.rr_interval_s / frames;
    for (int p = 0; p < frames; ++p) exam.stack.frame_times_s.push_back(recorded * p);
    check_signal(images);
    exam.decisions.push_back(
        "The stack is the 4-D file as it is: " + std::to_string(images.grid.size[2]) +
        " slices of " + std::to_string(frames) + " phases, uniform in the R-R interval.");
    if (options.phases > 0 && options.phases != frames) {
      resample(images, options.phases);
      exam.decisions.push_back("The frames were resampled to " + std::to_string(options.phases) +
                               " phases.");
    }
  } catch (const Error& error) {
    throw error.with_context(file.string());
  }
  context.progress(1);
  return exam;
}

}  // namespace beatlas::ingest
