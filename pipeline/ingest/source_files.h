#pragma once
/// Which files a source is, and of what kind.

#include <filesystem>
#include <vector>

#include "pipeline/core/stage_context.h"

namespace beatlas::ingest {

struct SourceFiles {
  /// Either image files (NIfTI, NRRD, MetaImage), in the order to read them, or empty.
  std::vector<std::filesystem::path> images;
  /// Else every file, to look for DICOM in.
  std::vector<std::filesystem::path> dicom;
  bool named = true;       ///< the user named each file; false: some were found in folders
  bool reordered = false;  ///< named in the order of a shell, taken in that of their numbers
  int left = 0;            ///< files beside the images that are none
  int studies = 0;         ///< studies of this program in the folders, which were left
};

struct FolderFiles {
  std::vector<std::filesystem::path> files;
  int studies = 0;  ///< studies of this program below the folder, none of whose files is in `files`
};

/// The regular files under a folder, however deep, that may be images of a source: not the files of
/// a study below it (a folder whose study.json holds "study_format"), which a build may have left
/// there itself, nor what macOS writes beside a file ("._name"). A folder that is a study or lies
/// in one is looked into.
/// @throws Error{InvalidInput} if the folder cannot be read
[[nodiscard]] FolderFiles files_under(const std::filesystem::path& folder, StageContext& context);

/// Looks into folders, however deep. Image files are taken only if nothing is DICOM: named ones in
/// their order, found ones in the natural order of their names (phase_2 before phase_10), and named
/// ones too if they stand as a shell lists them (phase_10 before phase_2). Hidden files (".name")
/// that were found are no image files.
/// @throws Error{InvalidInput} if a source is not there, an archive or a study, or image files and
///         others are named together
[[nodiscard]] SourceFiles find_files(const std::vector<std::filesystem::path>& sources,
                                     StageContext& context);

/// The files that images are read from, and whether their order counts.
struct ReadFiles {
  /// Of image files all that an image is read from together, header first and then what holds its
  /// voxels, image after image as they are read; DICOM files each alone, in no order.
  std::vector<std::vector<std::filesystem::path>> images;
  bool ordered = false;  ///< image files: they are the phases of a cine
};

/// Of what `find_files` finds that which `read_exam` takes images from: image files with the files
/// that their headers name, or what is DICOM by its first bytes. Notes and results that lie in the
/// same folders are none; DICOM files that were named one by one all are, for one that is none is
/// refused.
/// @throws Error{InvalidInput} as `find_files`, and if an image file's header cannot be read or
///         names files that are not there
[[nodiscard]] ReadFiles read_files(const std::vector<std::filesystem::path>& sources,
                                   StageContext& context);

/// Whether `a` comes before `b`: runs of digits compare as numbers. A strict total order.
[[nodiscard]] bool natural_less(const std::string& a, const std::string& b);

}  // namespace beatlas::ingest
