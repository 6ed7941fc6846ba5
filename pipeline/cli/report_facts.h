#pragma once
/// What a study tells of its package and stages, for its report.

#include <optional>
#include <vector>

#include "pipeline/assess/structural_checks.h"
#include "pipeline/report/report_data.h"
#include "pipeline/report/speed_table.h"
#include "pipeline/study/study.h"
#include "runtime/atlas/manifest.h"

namespace beatlas::cli {

/// What the stage pack leaves of a package in the study: its manifest as `info --json` gives it,
/// its size, and what `validate` says of it.
inline constexpr auto kPackContents = "pack/contents.json";
[[nodiscard]] nlohmann::json pack_contents(const atlas::Manifest& manifest, std::uint64_t bytes,
                                           const std::vector<assess::Check>& checks);

/// Of the package that was made last. None if there is none.
[[nodiscard]] std::optional<report::ReportPackage> packed_facts(const study::Study& study);

/// @param times of those that ran just now
[[nodiscard]] std::vector<report::ReportStage> stage_facts(
    const study::Study& study, const std::vector<report::StageTime>& times);

}  // namespace beatlas::cli
