#pragma once
/// Names that come from a file: they may lead anywhere.

#include <filesystem>

namespace beatlas {

/// Whether a file that is there lies in a folder or below it, whatever links are on the way.
[[nodiscard]] bool lies_within(const std::filesystem::path& file,
                               const std::filesystem::path& folder);

}  // namespace beatlas
