#include <algorithm>
#include <string>

#include "pipeline/ingest/exam_sources.h"
#include "pipeline/ingest/ingest.h"
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
    const auto [low, high] = std::minmax_element(phase.begin(), phase.end());
    if (*low == *high) {
      throw_invalid("phase " + std::to_string(p + 1) + " of " +
                    std::to_string(images.phases.size()) +
                    " shows nothing: all its voxels have one value");
    }
  }
}

Exam read_exam(const std::vector<fs::path>& sources, const IngestOptions& options,
               StageContext& context) {
  check(options);
  const SourceFiles files = find_files(sources, context);
  if (!files.images.empty()) {
    Exam exam = exam_from_images(files.images, files.named, options, context);
    if (files.left > 0) {
      exam.decisions.push_back(std::to_string(files.left) + (files.left == 1
                                                                 ? " other file was left."
                                                                 : " other files were left."));
    }
    return exam;
  }
  const std::string name =
      sources.front().string() + (sources.size() > 1 ? " and the other sources" : "");
  try {
    return exam_from_dicom(files.dicom, files.named, options, context);
  } catch (const Error& error) {
    // A message that names its file needs no folder.
    const std::string message = error.what();
    const bool names_file = std::any_of(
        files.dicom.begin(), files.dicom.end(),
        [&](const fs::path& file) { return message.rfind(file.string() + ": ", 0) == 0; });
    if (names_file || error.code() != ErrorCode::InvalidInput) throw;
    throw error.with_context(name);
  }
}

}  // namespace beatlas::ingest
