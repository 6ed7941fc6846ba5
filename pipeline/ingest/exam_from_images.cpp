#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <set>
#include <span>
#include <string>

#include "pipeline/core/parallel.h"
#include "pipeline/formats/image_file.h"
#include "pipeline/ingest/exam_sources.h"
#include "pipeline/ingest/frame_timing.h"
#include "pipeline/ingest/phase_resampling.h"
#include "pipeline/ingest/slice_axis.h"
#include "runtime/base/error.h"

namespace beatlas::ingest {
namespace {

namespace fs = std::filesystem;

constexpr int kLeastSlices = 3;
constexpr double kSamePlaceMm = 0.01;

std::string voxels(const Grid& grid) {
  return std::to_string(grid.size[0]) + " x " + std::to_string(grid.size[1]) + " x " +
         std::to_string(grid.size[2]);
}

bool same_place(const Grid& a, const Grid& b) {
  for (const int i : {0, a.size[0] - 1}) {
    for (const int j : {0, a.size[1] - 1}) {
      for (const int k : {0, a.size[2] - 1}) {
        if ((a.mm(i, j, k) - b.mm(i, j, k)).norm() > kSamePlaceMm) return false;
      }
    }
  }
  return true;
}

/// Whether an image holds whole numbers of so few values that they can only be names of structures.
bool looks_like_labels(const std::vector<float>& voxels) {
  constexpr std::size_t kMostLabels = 16;
  std::set<float> values;
  for (const float value : voxels) {
    if (value < 0 || value > 255 || value != std::floor(value)) return false;
    if (values.insert(value).second && values.size() > kMostLabels) return false;
  }
  return values.size() > 1;  // an image of one value is another fault
}

/// Images and labels of them in one list: the labels would be phases of the cine.
void refuse_labels_among_images(const ImageCycle<float>& images,
                                const std::vector<fs::path>& files) {
  std::vector<char> labels(files.size());
  parallel_for(files.size(),
               [&](std::size_t f) { labels[f] = looks_like_labels(images.phases[f]) ? 1 : 0; });
  const auto first = std::find(labels.begin(), labels.end(), 1);
  if (first == labels.end() || std::find(labels.begin(), labels.end(), 0) == labels.end()) return;
  throw_invalid(
      files[static_cast<std::size_t>(first - labels.begin())].string() +
      ": it holds labels, other files images; name the images alone, and give labels with "
      "--labels");
}

/// Appends the one image of a file of a list. @throws Error{InvalidInput} if it does not fit
void append(formats::ImageFile&& next, ImageCycle<float>& images, const fs::path& file) {
  const std::string name = file.string();
  if (next.images.phase_count() != 1) {
    throw_invalid(name +
                  ": it is 4-D and not the only image file; name the one 4-D file to read, "
                  "or 3-D files only, one a phase");
  }
  if (images.phases.empty()) images.grid = next.images.grid;
  if (next.images.grid.size != images.grid.size) {
    throw_invalid(name + ": it has " + voxels(next.images.grid) + " voxels, the first file " +
                  voxels(images.grid) + "; the phases of a cine are all of one size");
  }
  if (!same_place(next.images.grid, images.grid)) {
    throw_invalid(name +
                  ": it lies elsewhere in the patient than the first file; the phases of a "
                  "cine share one place");
  }
  images.phases.push_back(std::move(next.images.phases.front()));
}

formats::ImageFile read_list(const std::vector<fs::path>& files, StageContext& context) {
  formats::ImageFile out;
  out.header.frame_axis = formats::FrameAxis::Untold;
  std::size_t done = 0;
  bool one_phantom = true;
  for (const fs::path& file : files) {
    context.check_cancelled();
    formats::ImageFile next = formats::read_image_file(file);
    if (out.images.phases.empty()) {
      out.header.note = next.header.note;
      out.header.phantom_identity = next.header.phantom_identity;
    }
    one_phantom = one_phantom && next.header.phantom_identity == out.header.phantom_identity;
    append(std::move(next), out.images, file);
    context.progress(static_cast<double>(++done) / static_cast<double>(files.size()));
  }
  refuse_labels_among_images(out.images, files);
  if (!one_phantom) out.header.phantom_identity.clear();
  return out;
}

/// In place, a run of voxels at a time: a second cycle would double the memory.
void resample(ImageCycle<float>& images, const std::vector<double>& at, int phases) {
  constexpr std::size_t kRun = 1 << 14;
  const auto taps = resample_phases(at, phases);
  const std::size_t frames = images.phases.size();
  const std::size_t count = images.grid.count();
  images.phases.resize(std::max(frames, taps.size()));
  for (std::size_t p = frames; p < images.phases.size(); ++p) images.phases[p].resize(count);
  parallel_for((count + kRun - 1) / kRun, [&](std::size_t run) {
    const std::size_t first = run * kRun;
    std::vector<std::vector<float>> recorded(frames);
    for (std::size_t f = 0; f < frames; ++f) {
      const auto from = std::span(images.phases[f]).subspan(first, std::min(kRun, count - first));
      recorded[f].assign(from.begin(), from.end());
    }
    for (std::size_t p = 0; p < taps.size(); ++p) {
      blend_to(recorded, taps[p], images.phases[p].data() + first);
    }
  });
  images.phases.resize(taps.size());
}

void check_options(const IngestOptions& options) {
  if (!options.series.empty() || options.exam > 1 || options.stack > 1) {
    throw_invalid("series, exams and stacks are chosen among DICOM images; it is none");
  }
}

/// Slices along the third axis, wherever the file has them.
/// @return the sentence that tells the order of its voxels
std::string order_axes(ImageCycle<float>& images) {
  const int axis = slice_axis(images.grid);
  if (axis == 2) return "the order of its voxels is the file's.";
  put_axis_last(images, axis);
  constexpr std::array<const char*, 2> kNames{"first", "second"};
  char spacing[32];
  std::snprintf(spacing, sizeof spacing, "%.3g mm", images.grid.spacing_mm()[2]);
  return std::string("they lie ") + spacing + " apart along the file's " +
         kNames.at(static_cast<std::size_t>(axis)) +
         " axis, which was made the third; every voxel stays at its place in the patient.";
}

Exam to_exam(formats::ImageFile&& file, const IngestOptions& options) {
  Exam exam;
  exam.phantom_identity = file.header.phantom_identity;
  ImageCycle<float>& images = exam.stack.images = std::move(file.images);
  const int frames = images.phase_count();
  check_options(options);
  if (frames < 2) {
    throw_invalid(
        "it holds one image only: name a 4-D file with several phases, or a list of 3-D files, "
        "one a phase");
  }
  const std::string order_told = order_axes(images);
  if (images.grid.size[2] < kLeastSlices) {
    throw_invalid("it holds " + std::to_string(images.grid.size[2]) +
                  (images.grid.size[2] == 1 ? " slice" : " parallel slices") +
                  ", at least 3 are needed");
  }
  if (!file.header.note.empty()) exam.decisions.push_back("Warning: " + file.header.note);
  FrameTiming timing = time_frames(file.header, frames, options);
  exam.decisions.insert(exam.decisions.end(), timing.decisions.begin(), timing.decisions.end());
  exam.stack.rr_interval_s = timing.rr_s;
  exam.stack.frame_times_s = std::move(timing.time_s);
  check_signal(images);
  exam.decisions.push_back("The stack has " + std::to_string(images.grid.size[2]) + " slices of " +
                           std::to_string(frames) + " phases, " +
                           (timing.even ? "even in" : "unevenly spread over") +
                           " the R-R interval; " + order_told);
  const int phases = options.phases > 0 ? options.phases : frames;
  if (phases != frames || !timing.even) {
    resample(images, timing.phases, phases);
    exam.decisions.push_back(
        frames < kLeastFramesToBlend
            ? "Too few frames a cycle to blend: each frame was assigned to its phase of the R-R "
              "interval as it is."
            : "The frames were resampled to " + std::to_string(phases) +
                  " even phases of the R-R interval.");
  }
  return exam;
}

}  // namespace

Exam exam_from_images(const std::vector<fs::path>& files, bool as_given,
                      const IngestOptions& options, StageContext& context) {
  formats::ImageFile read =
      files.size() == 1 ? formats::read_image_file(files[0]) : read_list(files, context);
  context.check_cancelled();
  Exam exam;
  try {
    exam = to_exam(std::move(read), options);
  } catch (const Error& error) {
    const std::string first = files[0].string();
    throw error.with_context(files.size() == 1 ? first
                                               : "the list of " + std::to_string(files.size()) +
                                                     " files that begins with " + first);
  }
  exam.source_format = formats::format_name(*formats::format_of(files[0]));
  if (files.size() > 1) {
    exam.decisions.insert(exam.decisions.begin(),
                          "The " + std::to_string(files.size()) +
                              " files were taken as phases, one each, in the order " +
                              (as_given ? "given." : "of their names."));
  }
  context.progress(1);
  return exam;
}

}  // namespace beatlas::ingest
