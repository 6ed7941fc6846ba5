#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "pipeline/core/parallel.h"
#include "pipeline/ingest/dicom_pixels.h"
#include "pipeline/ingest/dicom_scan.h"
#include "pipeline/ingest/exam_sources.h"
#include "pipeline/ingest/phase_resampling.h"
#include "pipeline/ingest/stack_choice.h"
#include "runtime/base/error.h"

namespace beatlas::ingest {
namespace {

std::string counted(int count, const std::string& one, const std::string& many) {
  return std::to_string(count) + ' ' + (count == 1 ? one : many);
}

std::string told(const DicomScan& scan) {
  std::set<std::string> series;
  for (const DicomImage& image : scan.images) series.insert(image.series_uid);
  std::string out = "Read " + counted(static_cast<int>(scan.images.size()), "image", "images") +
                    " of " + counted(static_cast<int>(series.size()), "series", "series") +
                    " from " + counted(scan.files, "file", "files");
  const auto add = [&out](int count, const std::string& what) {
    if (count > 0) out += ", ignored " + std::to_string(count) + ' ' + what;
  };
  add(scan.not_dicom, "that are no DICOM");
  add(scan.not_image, "DICOM files without an image");
  add(scan.not_grey, "colour or inverted images");
  add(scan.without_place, "images without position, orientation or pixel spacing");
  add(scan.copies, "copies of an image already read");
  return out + '.';
}

/// Why a scan that gave no image gave none.
[[noreturn]] void nothing_found(const DicomScan& scan) {
  if (scan.files == 0) throw_invalid("the folder is empty");
  if (scan.not_grey > 0) throw_invalid("all its images are in colour, grey images are needed");
  if (scan.without_place > 0) {
    throw_invalid(
        "no image names its position, orientation and pixel spacing: export the original images");
  }
  throw_invalid("none of its " + counted(scan.files, "file", "files") + " is a DICOM image");
}

/// Reads and resamples the slices of a cine. Slice by slice, so that only one slice's source
/// frames are in memory beside the result.
Cine read_cine(const ChosenCine& chosen, int phases, const std::vector<DicomImage>& images,
               StageContext& context, int& done, int total) {
  Cine out;
  out.images.grid = chosen.grid;
  out.rr_interval_s = chosen.rr_s;
  out.images.phases.assign(static_cast<std::size_t>(phases),
                           std::vector<float>(chosen.grid.count()));
  DicomPixels pixels;
  for (std::size_t k = 0; k < chosen.slices.size(); ++k) {
    const ImageSet& set = chosen.slices[k];
    std::vector<std::vector<float>> frames;
    for (const int index : set.images) {
      context.check_cancelled();
      frames.push_back(pixels.read(images[static_cast<std::size_t>(index)]));
      ++done;
      context.progress(0.4 + 0.6 * done / total);
    }
    const auto taps = resample_phases(phases_of(set.timing, chosen.rr_s), phases);
    parallel_for(taps.size(), [&](std::size_t p) {
      const auto slice = blend(frames, taps[p]);
      std::copy(slice.begin(), slice.end(),
                out.images.phases[p].begin() +
                    static_cast<std::ptrdiff_t>(k * chosen.grid.slice_count()));
    });
  }
  // The slice nearest the middle speaks for the stack, of those with a frame a phase if there are.
  const int middle = static_cast<int>(chosen.slices.size()) / 2;
  int best = middle;
  bool found = false;
  for (int k = 0; k < static_cast<int>(chosen.slices.size()); ++k) {
    if (chosen.slices[static_cast<std::size_t>(k)].frames() != phases) continue;
    if (!found || std::abs(k - middle) < std::abs(best - middle)) best = k;
    found = true;
  }
  out.frame_times_s = chosen.slices[static_cast<std::size_t>(best)].timing.time_s;
  return out;
}

int image_count(const Choice& choice) {
  int out = 0;
  for (const ImageSet& set : choice.stack.slices) out += set.frames();
  for (const ChosenCine& view : choice.views) {
    for (const ImageSet& set : view.slices) out += set.frames();
  }
  return out;
}

/// Tells how frames became phases.
std::string resampling_told(const Choice& choice) {
  int copied = 0;
  int turned = 0;
  for (const ImageSet& set : choice.stack.slices) {
    const auto taps = resample_phases(phases_of(set.timing, choice.stack.rr_s), choice.phases);
    const bool copies =
        std::all_of(taps.begin(), taps.end(), [](const PhaseTaps& tap) { return tap.count == 1; });
    if (set.frames() < kLeastFramesToBlend) {
      ++turned;
    } else if (copies) {
      ++copied;
    }
  }
  const auto slices = static_cast<int>(choice.stack.slices.size());
  if (turned > 0) {
    return "Too few frames a cycle to blend: each frame was assigned to its phase of the R-R "
           "interval as it is.";
  }
  if (copied == slices) return "All frames lie on common phases of their R-R interval.";
  return counted(slices - copied, "slice was", "slices were") +
         " resampled to common phases of the R-R interval, the others' frames lie on them.";
}

}  // namespace

Exam exam_from_dicom(const std::vector<std::filesystem::path>& files, bool named,
                     const IngestOptions& options, StageContext& context) {
  const DicomScan scan = scan_dicom(files, named, context);
  if (scan.images.empty()) nothing_found(scan);
  const Choice choice = choose_stack(scan.images, options);

  Exam exam;
  exam.source_format = "dicom";
  exam.decisions.push_back(told(scan));
  if (scan.straightened > 0) {
    exam.decisions.push_back(
        "Warning: " + counted(scan.straightened, "image has", "images have") +
        " direction cosines that are not quite orthonormal; they were made so.");
  }
  exam.decisions.insert(exam.decisions.end(), choice.decisions.begin(), choice.decisions.end());
  exam.decisions.push_back(resampling_told(choice));

  int done = 0;
  const int total = image_count(choice);
  exam.stack = read_cine(choice.stack, choice.phases, scan.images, context, done, total);
  check_signal(exam.stack.images);
  for (const ChosenCine& view : choice.views) {
    exam.views.push_back(read_cine(view, choice.phases, scan.images, context, done, total));
  }
  if (options.rr_interval_s > 0) {
    exam.stack.rr_interval_s = options.rr_interval_s;
    exam.decisions.push_back("The R-R interval was given, not taken from the images.");
  }
  return exam;
}

}  // namespace beatlas::ingest
