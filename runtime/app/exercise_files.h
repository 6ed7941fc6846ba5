#pragma once
/// The folder of an exercise that is played: session.json, a CSV for each part of each trial, and
/// in the end score.json and report.html.

#include <filesystem>
#include <vector>

#include "runtime/app/kept_session.h"
#include "runtime/app/trace.h"

namespace beatlas::app {

[[nodiscard]] bool holds_session(const std::filesystem::path& folder);
/// @throws Error{InvalidInput} naming the file, and the JSON path of what is wrong
[[nodiscard]] KeptSession read_session(const std::filesystem::path& folder);
/// @throws Error{Machine} if it cannot be written whole
void write_session(const KeptSession& session, const std::filesystem::path& folder);

/// Writes a part's trace and then the session that names it, so that a session never names what is
/// not there.
void keep_part(const std::vector<TraceRow>& trace, bool done, const std::filesystem::path& folder,
               std::size_t trial, KeptSession& session);
/// @throws Error{InvalidInput} naming file, line and column
[[nodiscard]] std::vector<std::vector<TraceRow>> read_parts(const std::filesystem::path& folder,
                                                            const KeptTrial& trial);

}  // namespace beatlas::app
