#pragma once
#include <string>

#include "pipeline/core/exam.h"

namespace beatlas::cli {

/// SHA-256 over the decoded stack: a text of size, map (as the bits of 16 doubles), R-R interval
/// and frame times, followed by the SHA-256 of each phase's voxels. Says whether two packages come
/// from the same images, whatever the format or the folder they were read from.
[[nodiscard]] std::string stack_sha256(const Cine& stack);

}  // namespace beatlas::cli
