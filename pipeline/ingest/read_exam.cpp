#include <algorithm>
#include <string>

#include "pipeline/ingest/exam_sources.h"
#include "pipeline/ingest/ingest.h"
#include "pipeline/ingest/slice_timing.h"
#include "runtime/base/error.h"

namespace beatlas::ingest {
namespace {

namespace fs = std::filesystem;

bool ends_with(const fs::path& file, const std::string& end) {
  std::string name = file.filename().string();
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return name.size() >= end.size() && name.compare(name.size() - end.size(), end.size(), end) == 0;
}

bool is_nifti(const fs::path& file) {
  return ends_with(file, ".nii") || ends_with(file, ".nii.gz");
}

void refuse_unknown(const fs::path& file) {
  for (const char* end : {".mha", ".mhd", ".nrrd", ".nhdr"}) {
    if (ends_with(file, end)) {
      throw_invalid(file.string() +
                    ": MetaImage and NRRD are not read yet; convert it to 4-D NIfTI");
    }
  }
  for (const char* end : {".zip", ".tar", ".tgz", ".tar.gz", ".7z"}) {
    if (ends_with(file, end)) {
      throw_invalid(file.string() + ": unpack the archive and name the folder");
    }
  }
}

void add_folder(const fs::path& folder, std::vector<fs::path>& files, StageContext& context) {
  std::error_code error;
  auto it = fs::recursive_directory_iterator(folder, fs::directory_options::skip_permission_denied,
                                             error);
  for (; !error && it != fs::recursive_directory_iterator(); it.increment(error)) {
    context.check_cancelled();
    std::error_code ignored;
    if (it->is_regular_file(ignored)) files.push_back(it->path());
  }
  if (error) throw_invalid(folder.string() + ": the folder cannot be read");
}

void check(const std::vector<fs::path>& sources, const IngestOptions& options) {
  if (sources.empty()) throw_invalid("no source is named: name a DICOM folder or a 4-D NIfTI file");
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

Exam read_exam(const std::vector<fs::path>& sources, const IngestOptions& options,
               StageContext& context) {
  check(sources, options);
  std::vector<fs::path> files;
  bool named = true;
  for (const fs::path& source : sources) {
    std::error_code ignored;
    if (!fs::exists(source, ignored)) throw_invalid(source.string() + ": no such file or folder");
    if (fs::is_directory(source, ignored)) {
      add_folder(source, files, context);
      named = false;
    } else {
      refuse_unknown(source);
      files.push_back(source);
    }
  }
  if (std::any_of(sources.begin(), sources.end(), is_nifti)) {
    if (sources.size() > 1) {
      throw_invalid(sources.front().string() +
                    ": name one 4-D NIfTI file, or DICOM folders, not both");
    }
    if (named) return exam_from_nifti(sources.front(), options, context);
  }
  const std::string name =
      sources.front().string() + (sources.size() > 1 ? " and the other sources" : "");
  const bool no_dicom = std::none_of(files.begin(), files.end(),
                                     [](const fs::path& file) { return !is_nifti(file); });
  if (!files.empty() && no_dicom) {
    throw_invalid(name + ": the folder holds NIfTI files only; name the 4-D file itself");
  }
  return exam_from_dicom(sources, files, named, options, context);
}

}  // namespace beatlas::ingest
