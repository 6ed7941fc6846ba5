#include <algorithm>
#include <cmath>
#include <set>
#include <span>
#include <string>
#include <utility>

#include "pipeline/core/parallel.h"
#include "pipeline/ingest/dicom_pixels.h"
#include "pipeline/ingest/dicom_scan.h"
#include "pipeline/ingest/exam_list.h"
#include "pipeline/ingest/exam_sources.h"
#include "pipeline/ingest/phase_resampling.h"
#include "pipeline/ingest/slice_resampling.h"
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
  const auto add = [&out](int count, const std::string& one, const std::string& many) {
    if (count > 0) out += ", ignored " + counted(count, one, many);
  };
  add(scan.not_dicom, "that is no DICOM", "that are no DICOM");
  add(static_cast<int>(scan.empty.size()), "empty file", "empty files");
  add(scan.not_image, "DICOM file without an image", "DICOM files without an image");
  add(scan.not_standard, "file of a private transfer syntax", "files of a private transfer syntax");
  add(scan.not_grey, "colour image", "colour images");
  add(scan.without_place, "image without position, orientation or pixel spacing",
      "images without position, orientation or pixel spacing");
  add(scan.copies, "copy of an image already read", "copies of an image already read");
  return out + '.';
}

/// What of the files is unusual, if it is part of what was taken.
void tell_oddities(const DicomScan& scan, const std::vector<std::filesystem::path>& sources,
                   std::vector<std::string>& decisions, const StageContext& context) {
  if (!scan.empty.empty()) {
    decisions.push_back(
        "Warning: " + counted(static_cast<int>(scan.empty.size()), "file is", "files are") +
        " empty; what was an image is to be copied again.");
    // Names are no part of the exam.
    context.warn(shown_below(sources, scan.empty.front(), scan.words) + " is empty");
  }
  const auto images = [](int count) { return counted(count, "image has", "images have"); };
  if (scan.straightened > 0) {
    decisions.push_back("Warning: " + images(scan.straightened) +
                        " direction cosines that are not quite orthonormal; they were made so.");
  }
  if (scan.inverted > 0) {
    decisions.push_back("Warning: " + images(scan.inverted) +
                        " inverted grey levels (MONOCHROME1); they were turned upright.");
  }
  if (scan.shared_uids > 0) {
    decisions.push_back("Warning: " + images(scan.shared_uids) +
                        " the UID of another image but not its content; all were kept.");
  }
  for (const auto& [modality, count] : scan.other_modalities) {
    decisions.push_back("Warning: " + counted(count, "image is", "images are") + " of modality " +
                        (modality.empty() ? "unknown" : modality) +
                        ", not MR; the result is untested for it.");
  }
}

bool holds_linked_folder(const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  std::error_code error;
  fs::recursive_directory_iterator it(folder, fs::directory_options::skip_permission_denied, error);
  for (; !error && it != fs::recursive_directory_iterator(); it.increment(error)) {
    std::error_code ignored;
    if (it->is_symlink(ignored) && it->is_directory(ignored)) return true;
  }
  return false;
}

/// Why a scan that gave no image gave none.
[[noreturn]] void nothing_found(const DicomScan& scan,
                                const std::vector<std::filesystem::path>& sources) {
  if (scan.files == 0) {
    if (std::any_of(sources.begin(), sources.end(), holds_linked_folder)) {
      throw_invalid(
          "it holds links to folders, which are not followed, and no file; name the "
          "folders that they lead to");
    }
    throw_invalid("the folder is empty");
  }
  // The standard gives the index of a folder this name, in these letters (PS3.10 8.6).
  if (std::any_of(sources.begin(), sources.end(),
                  [](const auto& source) { return source.filename() == "DICOMDIR"; })) {
    throw_invalid("it is the index of a DICOM folder and no image; name the folder it lies in");
  }
  if (scan.not_grey > 0) throw_invalid("all its images are in colour, grey images are needed");
  if (scan.without_place > 0) {
    throw_invalid(
        "no image names its position, orientation and pixel spacing: export the original images");
  }
  throw_invalid("none of its " + counted(scan.files, "file", "files") + " is a DICOM image");
}

/// Names the first image that could not be used, by the order of the scan, and counts the others.
void refuse_bad(const std::vector<std::pair<int, PixelState>>& bad,
                const std::vector<DicomImage>& images, const ImageFiles& files) {
  if (bad.empty()) return;
  const auto first = std::min_element(bad.begin(), bad.end());
  const auto& image = images[static_cast<std::size_t>(first->first)];
  std::string what = files.shown(image.file) + ": ";
  what += first->second == PixelState::NoNumber
              ? "it holds pixels that are no number (NaN or infinite); export it again"
              : "its pixels cannot be decoded; the file is damaged or packed in a way that is not "
                "supported";
  if (bad.size() > 1) what += " (" + std::to_string(bad.size() - 1) + " more images are as bad)";
  throw_invalid(what);
}

/// Where reading stands, of all images that will be read.
struct Reading {
  const std::vector<DicomImage>& images;
  const ImageFiles& files;
  StageContext& context;
  DicomPixels& pixels;
  int done = 0;
  int total = 0;
};

/// Reads an image on the pixels of its stack.
PixelState read_onto(const SliceResampling& onto, const DicomPixels& pixels,
                     const DicomImage& image, std::span<float> out) {
  if (onto.same()) return pixels.read(image, out);
  std::vector<float> own(static_cast<std::size_t>(image.columns) *
                         static_cast<std::size_t>(image.rows));
  const PixelState state = pixels.read(image, own);
  if (state == PixelState::Good) onto.resample(own, out);
  return state;
}

/// The slice whose times speak for the stack: nearest the middle, of those with a frame a phase if
/// there are.
const ImageSet& speaking_slice(const ChosenCine& chosen, int phases) {
  const int slices = static_cast<int>(chosen.slices.size());
  const int middle = slices / 2;
  int best = middle;
  bool found = false;
  for (int k = 0; k < slices; ++k) {
    if (chosen.slices[static_cast<std::size_t>(k)].frames() != phases) continue;
    if (!found || std::abs(k - middle) < std::abs(best - middle)) best = k;
    found = true;
  }
  return chosen.slices[static_cast<std::size_t>(best)];
}

/// Of the slice that speaks for the stack; even over the R-R interval where it tells no time.
std::vector<double> frame_times_of(const ChosenCine& chosen, int phases) {
  const SliceTiming& timing = speaking_slice(chosen, phases).timing;
  std::vector<double> out = timing.time_s;
  if (timing.timed || timing.rr_s != 0) return out;
  for (std::size_t f = 0; f < out.size(); ++f) {
    out[f] = chosen.rr_s * static_cast<double>(f) / static_cast<double>(out.size());
  }
  return out;
}

/// Reads and resamples the slices of a cine; those that were not imaged stay 0. A few slices at a
/// time, so that little more than the result is in memory.
Cine read_cine(const ChosenCine& chosen, int phases, Reading& reading) {
  Cine out;
  out.images.grid = chosen.grid;
  out.rr_interval_s = chosen.rr_s;
  std::vector<std::pair<int, PixelState>> bad;
  std::vector<std::vector<float>> frames;  // of a slice that is blended
  // What several slices share is decoded once, unless that takes more than the result.
  const double most_bytes =
      0.8 * sizeof(float) * static_cast<double>(chosen.grid.count()) * std::max(phases, 1);
  for (std::size_t n = 0; n < chosen.slices.size(); ++n) {
    const ImageSet& set = chosen.slices[n];
    const int k = chosen.numbers[n];
    reading.context.check_cancelled();
    const auto image = [&](std::size_t f) -> const DicomImage& {
      return reading.images[static_cast<std::size_t>(set.images[f])];
    };
    for (std::size_t f = 0; f < set.images.size(); ++f)
      reading.pixels.prepare(image(f), most_bytes);
    if (out.images.phases.empty()) {  // not before: what a decoder needs on its way is free now
      out.images.phases.resize(static_cast<std::size_t>(phases));
      parallel_for(out.images.phases.size(),
                   [&](std::size_t p) { out.images.phases[p].resize(chosen.grid.count()); });
    }
    const std::size_t count = chosen.grid.slice_count();
    const auto taps = resample_phases(phases_of(set.timing, chosen.rr_s), phases);
    const bool copies =
        std::all_of(taps.begin(), taps.end(), [](const PhaseTaps& tap) { return tap.count == 1; });
    const auto place = [&](std::size_t p) {
      return std::span(out.images.phases[p]).subspan(static_cast<std::size_t>(k) * count, count);
    };
    const SliceResampling onto(image(0), chosen.grid, k);
    const auto read = [&](std::size_t f, std::span<float> pixels) {
      return read_onto(onto, reading.pixels, image(f), pixels);
    };
    std::vector<PixelState> states(copies ? taps.size() : set.images.size());
    if (copies) {
      parallel_for(taps.size(), [&](std::size_t p) {
        states[p] = read(static_cast<std::size_t>(taps[p].frame[0]), place(p));
      });
    } else {
      frames.resize(set.images.size());
      parallel_for(frames.size(), [&](std::size_t f) {
        frames[f].resize(count);
        states[f] = read(f, frames[f]);
      });
    }
    for (std::size_t i = 0; i < states.size(); ++i) {
      const std::size_t f = copies ? static_cast<std::size_t>(taps[i].frame[0]) : i;
      if (states[i] != PixelState::Good) bad.emplace_back(set.images[f], states[i]);
    }
    reading.done += set.frames();
    reading.context.progress(0.4 + 0.6 * reading.done / reading.total);
    if (copies || !bad.empty()) continue;
    parallel_for(taps.size(), [&](std::size_t p) { blend_to(frames, taps[p], place(p).data()); });
  }
  reading.pixels.release();
  refuse_bad(bad, reading.images, reading.files);
  out.frame_times_s = frame_times_of(chosen, phases);
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
         " resampled to common phases of the R-R interval" +
         (copied > 0 ? ", the others' frames lie on them." : ".");
}

/// Of the phantom that every image of the stack names; else empty.
std::string phantom_identity(const ChosenCine& stack, const std::vector<DicomImage>& images) {
  const std::string& first =
      images[static_cast<std::size_t>(stack.slices.front().images.front())].phantom_identity;
  for (const ImageSet& slice : stack.slices) {
    for (const int image : slice.images) {
      if (images[static_cast<std::size_t>(image)].phantom_identity != first) return {};
    }
  }
  return first;
}

bool holds_stack(const std::vector<DicomImage>& images, const IngestOptions& options,
                 const ImageFiles& files) {
  IngestOptions any = options;
  any.stack = 0;
  any.frame_times_s.clear();
  try {
    (void)choose_stack(images, any, files);
  } catch (const Error&) {
    return false;
  }
  return true;
}

Exam exam_of(const DicomScan& scan, const std::vector<std::filesystem::path>& sources,
             const IngestOptions& options, const ImageFiles& files, DicomPixels& pixels,
             StageContext& context) {
  if (scan.images.empty()) nothing_found(scan, sources);
  ImageFiles listed = files;
  listed.shown = [&](const std::filesystem::path& file) {
    return shown_below(sources, file, scan.words);
  };
  const ExamChoice chosen = choose_exam(
      scan.images, options.exam, options.series,
      [&](const std::vector<DicomImage>& images) { return holds_stack(images, options, files); },
      listed);
  const Choice choice = choose_stack(chosen.images, options, files);

  Exam exam;
  exam.source_format = "dicom";
  exam.decisions.push_back(told(scan));
  tell_oddities(scan, sources, exam.decisions, context);
  exam.decisions.insert(exam.decisions.end(), chosen.decisions.begin(), chosen.decisions.end());
  exam.decisions.insert(exam.decisions.end(), choice.decisions.begin(), choice.decisions.end());
  exam.decisions.push_back(resampling_told(choice));

  Reading reading{chosen.images, files, context, pixels};
  reading.total = image_count(choice);
  exam.stack = read_cine(choice.stack, choice.phases, reading);
  exam.phantom_identity = phantom_identity(choice.stack, chosen.images);
  check_signal(exam.stack.images);
  for (const ChosenCine& view : choice.views) {
    exam.views.push_back(read_cine(view, choice.phases, reading));
  }
  if (options.rr_interval_s > 0) {
    exam.stack.rr_interval_s = options.rr_interval_s;
    const auto& all = choice.stack.slices;
    const bool own = std::any_of(all.begin(), all.end(), [&](const ImageSet& set) {
      return set.timing.rr_s > 0 && std::abs(set.timing.rr_s - options.rr_interval_s) > 0.5e-3;
    });
    exam.decisions.emplace_back(own ? "The R-R interval was given, not taken from the images: it "
                                      "is the mean of the slices, "
                                      "whose own intervals keep their proportions."
                                    : "The R-R interval was given, not taken from the images.");
  }
  if (!options.frame_times_s.empty()) {
    exam.decisions.emplace_back("The frame times were given, not taken from the images.");
  }
  return exam;
}

}  // namespace

Exam exam_from_dicom(const std::vector<std::filesystem::path>& sources,
                     const std::vector<std::filesystem::path>& files, bool named,
                     const IngestOptions& options, StageContext& context) {
  const DicomScan scan = scan_dicom(sources, files, named, context);
  DicomPixels pixels;
  bool names_file = false;  // a message that names its file needs no folder
  const ImageFiles access{
      .shown =
          [&](const std::filesystem::path& file) {
            names_file = true;
            return shown_to(sources, file, scan.words);
          },
      .fingerprint = [&](const DicomImage& image) { return pixels.fingerprint(image); }};
  const std::string shown =
      shown_to(sources, sources.front()) + (sources.size() > 1 ? " and the other sources" : "");
  try {
    Exam exam = exam_of(scan, sources, options, access, pixels, context);
    exam.shown_source = shown;
    return exam;
  } catch (const Error& error) {
    if (names_file || error.code() != ErrorCode::InvalidInput) throw;
    throw error.with_context(shown);
  }
}

}  // namespace beatlas::ingest
