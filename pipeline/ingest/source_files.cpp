#include "pipeline/ingest/source_files.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <string>

#include "pipeline/core/words.h"
#include "pipeline/formats/image_file.h"
#include "pipeline/ingest/dicom_file.h"
#include "runtime/base/error.h"

namespace beatlas::ingest {
namespace {

bool decimal(char c) { return c >= '0' && c <= '9'; }

namespace fs = std::filesystem;

/// Whether DICOM's mark stands behind the preamble. Files without one exist, but not under the
/// names of image files.
bool has_dicom_mark(const fs::path& file) {
  std::array<char, 132> start{};
  std::ifstream in(file, std::ios::binary);
  return in.read(start.data(), start.size()) && std::string_view(&start[128], 4) == "DICM";
}

bool is_archive(const fs::path& file) {
  std::string name = file.filename().string();
  std::transform(name.begin(), name.end(), name.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  for (const char* end :
       {".zip", ".tar", ".tgz", ".tar.gz", ".tar.bz2", ".tar.xz", ".7z", ".rar"}) {
    if (name.ends_with(end)) return true;
  }
  return false;
}

bool is_image(const fs::path& file) {
  if (!formats::format_of(file)) return false;
  // Some archives name DICOM images .img.
  return !formats::may_be_voxels_of_another(file) || !has_dicom_mark(file);
}

bool is_hidden(const fs::path& file) { return file.filename().string().starts_with('.'); }

/// Whether a build keeps its work in this folder.
bool is_study(const fs::path& folder) {
  std::ifstream in(folder / "study.json", std::ios::binary);
  constexpr std::string_view kMark = "\"study_format\"";
  std::string text;  // the end of the piece before, and a piece: the mark may lie across both
  std::array<char, 4096> piece{};
  while (in) {
    in.read(piece.data(), piece.size());
    text.append(piece.data(), static_cast<std::size_t>(in.gcount()));
    if (text.find(kMark) != std::string::npos) return true;
    if (text.size() > kMark.size()) text.erase(0, text.size() - kMark.size());
  }
  return false;
}

bool naturally_less(const fs::path& a, const fs::path& b) {
  return natural_less(a.string(), b.string());
}

bool text_less(const fs::path& a, const fs::path& b) { return a.string() < b.string(); }

/// Whether the files are numbered: nobody lists 1, 10, 2 but a shell.
bool only_numbers_differ(const std::vector<fs::path>& files) {
  const auto without_digits = [](const fs::path& file) {
    std::string name = file.string();
    std::erase_if(name, decimal);
    return name;
  };
  const std::string first = without_digits(files.front());
  return std::all_of(files.begin(), files.end(),
                     [&](const fs::path& file) { return without_digits(file) == first; });
}

/// Of the files of some folders: images if there are any and nothing is DICOM.
void sort_out(const std::vector<fs::path>& files, SourceFiles& out) {
  std::vector<fs::path> images;
  bool dicom = false;
  for (const fs::path& file : files) {
    if (is_hidden(file) && formats::format_of(file)) continue;
    if (formats::may_be_voxels_of_another(file) && is_image(file)) continue;  // a header's
    if (is_image(file)) {
      images.push_back(file);
    } else if (!dicom) {
      dicom = has_dicom_mark(file);
    }
  }
  if (images.empty() || dicom) {
    out.dicom = files;
    return;
  }
  std::sort(images.begin(), images.end(), naturally_less);
  for (const fs::path& file : files) {
    if (!is_hidden(file) && !is_image(file) && !formats::may_be_voxels_of_another(file)) ++out.left;
  }
  out.images = std::move(images);
}

}  // namespace

bool natural_less(const std::string& a, const std::string& b) {
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.size() && j < b.size()) {
    if (decimal(a[i]) && decimal(b[j])) {
      const std::size_t i0 = std::min(a.find_first_not_of('0', i), a.size());
      const std::size_t j0 = std::min(b.find_first_not_of('0', j), b.size());
      std::size_t i1 = i0;
      std::size_t j1 = j0;
      while (i1 < a.size() && decimal(a[i1])) ++i1;
      while (j1 < b.size() && decimal(b[j1])) ++j1;
      if (i1 - i0 != j1 - j0) return i1 - i0 < j1 - j0;
      if (const int order = a.compare(i0, i1 - i0, b, j0, j1 - j0); order != 0) return order < 0;
      i = i1;
      j = j1;
    } else {
      if (a[i] != b[j]) return static_cast<unsigned char>(a[i]) < static_cast<unsigned char>(b[j]);
      ++i;
      ++j;
    }
  }
  if (a.size() - i != b.size() - j) return a.size() - i < b.size() - j;
  return a < b;  // alike but for zeros in front of numbers
}

FolderFiles files_under(const fs::path& folder, StageContext& context) {
  FolderFiles out;
  std::error_code error;
  auto it = fs::recursive_directory_iterator(folder, fs::directory_options::skip_permission_denied,
                                             error);
  for (; !error && it != fs::recursive_directory_iterator(); it.increment(error)) {
    context.check_cancelled();
    std::error_code ignored;
    if (it->is_directory(ignored)) {
      if (!it->is_symlink(ignored) && is_study(it->path())) {
        it.disable_recursion_pending();
        ++out.studies;
      }
    } else if (it->is_regular_file(ignored) && !it->path().filename().string().starts_with("._")) {
      out.files.push_back(it->path());
    }
  }
  if (error) throw_invalid(folder.string() + ": the folder cannot be read");
  return out;
}

SourceFiles find_files(const std::vector<fs::path>& named, StageContext& context) {
  if (named.empty()) {
    throw_invalid(
        "no source is named: name a DICOM folder, a 4-D image file or a list of 3-D ones");
  }
  std::vector<fs::path> sources = named;
  for (fs::path& source : sources) {
    // A phantom's folder holds true labels beside its images.
    std::error_code ignored;
    const fs::path cine = source / "cine.nii.gz";
    if (fs::is_regular_file(source / "truth.json", ignored) && fs::is_regular_file(cine, ignored)) {
      source = cine;
    }
  }
  SourceFiles out;
  std::vector<fs::path> files;
  for (const fs::path& source : sources) {
    std::error_code ignored;
    if (!fs::exists(source, ignored)) throw_invalid(source.string() + ": no such file or folder");
    if (fs::is_directory(source, ignored)) {
      if (is_study(source)) {
        throw_invalid(
            source.string() +
            ": it is a study, which a build left, and no images; 'beatlas build --study " +
            shell_word(source.string()) + "' builds it again, 'beatlas status " +
            shell_word(source.string()) + "' tells what is done");
      }
      FolderFiles found = files_under(source, context);
      out.studies += found.studies;
      files.insert(files.end(), std::make_move_iterator(found.files.begin()),
                   std::make_move_iterator(found.files.end()));
      out.named = false;
    } else if (is_archive(source)) {
      throw_invalid(source.string() + ": unpack the archive and name the folder");
    } else {
      files.push_back(source);
    }
  }
  const auto named_image = std::find_if(sources.begin(), sources.end(), [](const fs::path& source) {
    std::error_code ignored;
    return !fs::is_directory(source, ignored) && is_image(source);
  });
  if (named_image != sources.end()) {
    if (!out.named || !std::all_of(files.begin(), files.end(), is_image)) {
      throw_invalid(named_image->string() +
                    ": name image files (NIfTI, NRRD, MetaImage) or DICOM, not both");
    }
    if (only_numbers_differ(files) && std::is_sorted(files.begin(), files.end(), text_less) &&
        !std::is_sorted(files.begin(), files.end(), naturally_less)) {
      std::sort(files.begin(), files.end(), naturally_less);
      out.reordered = true;
    }
    out.images = std::move(files);
    return out;
  }
  if (!files.empty() && std::all_of(files.begin(), files.end(), is_archive)) {
    throw_invalid(sources.front().string() +
                  ": it holds archives only; unpack them and name the folder");
  }
  sort_out(files, out);
  return out;
}

ReadFiles read_files(const std::vector<fs::path>& sources, StageContext& context) {
  const SourceFiles found = find_files(sources, context);
  ReadFiles out;
  out.ordered = !found.images.empty();
  for (const fs::path& image : found.images) out.images.push_back(formats::files_of_image(image));
  for (const fs::path& file : found.dicom) {
    context.check_cancelled();
    if (found.named || is_dicom(file)) out.images.push_back({file});
  }
  return out;
}

}  // namespace beatlas::ingest
