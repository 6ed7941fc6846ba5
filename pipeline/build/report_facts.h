#pragma once
/// What a study or a package tells of itself, for its report.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/assess/structural_checks.h"
#include "pipeline/report/report_data.h"
#include "pipeline/report/speed_table.h"
#include "pipeline/study/study.h"
#include "runtime/atlas/atlas.h"
#include "runtime/atlas/manifest.h"

namespace beatlas::build {

/// Volumes that a package's own surfaces enclose, the finest of each structure [ml].
[[nodiscard]] std::vector<report::VolumeCurve> enclosed_volumes(const atlas::Atlas& package);

/// What the stage pack leaves of a package in the study: its manifest as `info --json` gives it,
/// its size, what `validate` says of it, and what its surfaces enclose.
inline constexpr auto kPackContents = "pack/contents.json";
[[nodiscard]] nlohmann::json pack_contents(const atlas::Manifest& manifest, std::uint64_t bytes,
                                           const std::vector<assess::Check>& checks,
                                           const std::vector<report::VolumeCurve>& enclosed);

/// Of a package, from what pack_contents gives of it. Its provenance may come from elsewhere: what
/// it does not tell is left out.
/// @throws nlohmann::json::exception if the provenance is another than `pack` writes
[[nodiscard]] report::ReportPackage package_facts(const nlohmann::json& contents,
                                                  const std::string& sha256);

/// How whole a surface is in its worst phase.
[[nodiscard]] report::SurfaceFigures surface_figures(const SurfaceCycle& surface);

/// Of the package that was made last. None if there is none.
[[nodiscard]] std::optional<report::ReportPackage> packed_facts(const study::Study& study);

/// Volumes and ejection fraction of the LV with their intervals, in a line; empty without an LV.
[[nodiscard]] std::string told_figures(const nlohmann::json& summary);

/// A report in a line. @param summary what report.json holds
[[nodiscard]] std::string told_report(const nlohmann::json& summary,
                                      const std::filesystem::path& page);

/// @param times of those that ran just now
[[nodiscard]] std::vector<report::ReportStage> stage_facts(
    const study::Study& study, const std::vector<report::StageTime>& times);

}  // namespace beatlas::build
