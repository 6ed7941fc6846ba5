#pragma once
#include <filesystem>

namespace beatlas::cli {

/// What a user may have at hand and name in a package's place is told by what it is, with the
/// command that takes it. What is none of that is left to the reader.
/// @throws Error{InvalidInput} for a study, another folder and an image
void refuse_what_is_no_package(const std::filesystem::path& file);

}  // namespace beatlas::cli
