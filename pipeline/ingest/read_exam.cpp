#include <algorithm>
#include <string>

#include "pipeline/ingest/exam_sources.h"
#include "pipeline/ingest/ingest.h"
#include "pipeline/ingest/shown_path.h"
#include "pipeline/ingest/slice_timing.h"
#include "pipeline/ingest/source_files.h"
#include "runtime/base/error.h"

namespace beatlas::ingest {
namespace {

namespace fs = std::filesystem;

void check(const IngestOptions& options) {
  if (options.rr_interval_s != 0 &&
      !(options.rr_interval_s >= kLeastRrS && options.rr_interval_s <= kMostRrS)) {
    throw_invalid("the R-R interval must be 0.2 to 3 s");
  }
  if (options.phases != 0 && (options.phases < 2 || options.phases > 200)) {
    throw_invalid("the number of phases must be 2 to 200, or 0 for the source's");
  }
}

}  // namespace

void check_signal(const ImageCycle<float>& images) {
  for (std::size_t p = 0; p < images.phases.size(); ++p) {
    const auto& phase = images.phases[p];
    if (std::all_of(phase.begin(), phase.end(), [&](float v) { return v == phase.front(); })) {
      throw_invalid("phase " + std::to_string(p + 1) + " of " +
                    std::to_string(images.phases.size()) +
                    " shows nothing: all its voxels have one value");
    }
  }
}

namespace {

/// The same error with files that were found in a source as messages may show them.
Error with_shown_paths(const Error& error, const std::vector<fs::path>& found,
                       const std::vector<fs::path>& sources) {
  std::string message = error.what();
  for (const fs::path& path : found) {
    const std::string plain = path.string();
    const std::string shown = shown_to(sources, path);
    if (plain.empty() || shown == plain) continue;
    for (std::size_t at = message.find(plain); at != std::string::npos;
         at = message.find(plain, at + shown.size())) {
      message.replace(at, plain.size(), shown);
    }
  }
  return {error.code(), message};
}

}  // namespace

Exam read_exam(const std::vector<fs::path>& sources, const IngestOptions& options,
               StageContext& context) {
  check(options);
  SourceFiles files;
  Exam exam;
  try {
    files = find_files(sources, context);
    if (!files.images.empty()) {
      exam = exam_from_images(files.images, files.named && !files.reordered, options, context);
      exam.shown_source = shown_to(sources, sources.front());
    }
  } catch (const Error& error) {
    throw with_shown_paths(error, files.images, sources);
  }
  if (files.images.empty()) {
    exam = exam_from_dicom(sources, files.dicom, files.named, options, context);
  }
  if (files.studies > 0) {
    exam.decisions.push_back(std::to_string(files.studies) +
                             (files.studies == 1 ? " study in the folder was left."
                                                 : " studies in the folder were left."));
  }
  if (files.left > 0) {
    exam.decisions.push_back(std::to_string(files.left) + (files.left == 1
                                                               ? " other file was left."
                                                               : " other files were left."));
  }
  return exam;
}

}  // namespace beatlas::ingest
