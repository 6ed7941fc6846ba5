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

/// SHA-256 over the sorted SHA-256 of the contents of all files under `sources` that the
/// reader looks at (ingest::files_under: without studies that a build left there), and their
/// number: the same whatever the files are called or how they are ordered, but for files that the
/// user named one by one, whose order counts. Nothing if one of them cannot be read.
[[nodiscard]] std::optional<std::string> files_sha256(
    const std::vector<std::filesystem::path>& sources);

}  // namespace beatlas::build
