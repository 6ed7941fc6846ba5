#pragma once
/// The report of a package alone: what it holds and what its maker told, without the study.

#include <filesystem>

#include <nlohmann/json.hpp>

#include "pipeline/core/stage_context.h"

namespace beatlas::cli {

/// Writes the page and gives what report.json would hold. Outlines are where the package's
/// distances are zero in the middle of a slice, on its images where it has them; what only the
/// study knows, leaks, boundaries that are hardly seen and shifts of slices, is left out.
/// @throws Error{InvalidInput} if the file is no package
nlohmann::json report_package(const std::filesystem::path& file, const std::filesystem::path& page,
                              StageContext& context);

}  // namespace beatlas::cli
