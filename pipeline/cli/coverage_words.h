#pragma once
/// The shares of voxels that came with labels from elsewhere: the folder that --coverage names.

#include <filesystem>
#include <map>
#include <string>

#include "pipeline/study/given_files.h"

namespace beatlas::cli {

/// "coverage_STRUCTURE.nii.gz", as in the study's segment/.
[[nodiscard]] std::string coverage_file_name(Structure structure);

/// The folder's images of these names, without the empty rim around what they cover.
/// @throws Error{InvalidInput} if there is none, if one is called after no structure, is no image,
/// holds values beyond 0..1 or covers nothing.
[[nodiscard]] std::map<Structure, study::GivenImages> read_coverage(
    const std::filesystem::path& folder);

}  // namespace beatlas::cli
