#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/core/exam.h"

namespace beatlas::build {

/// SHA-256 over the decoded stack: a text of size, map (as the bits of 16 doubles), R-R interval
/// and frame times, followed by the SHA-256 of each phase's voxels. Says whether two packages come
/// from the same images, whatever the format or the folder they were read from.
[[nodiscard]] std::string stack_sha256(const Cine& stack);

/// SHA-256 over the SHA-256 of the contents of files, in their order: of what an exam was made from
/// that is no source of images. Nothing if one of them cannot be read.
[[nodiscard]] std::optional<std::string> files_sha256(
    const std::vector<std::filesystem::path>& files);

/// The same of the files that the reader takes the images of a source from (ingest::read_files):
/// not of others in its folders, such as notes or what a build left there. Of image files those
/// that their headers name are hashed with them, and the order in which they are read counts, since
/// it is that of the phases; of DICOM neither names nor order count. Nothing if the reader would
/// refuse the source.
[[nodiscard]] std::optional<std::string> source_sha256(
    const std::vector<std::filesystem::path>& sources);

}  // namespace beatlas::build
