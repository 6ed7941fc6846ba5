#pragma once
/// The folder of an exercise that is played: session.json, a CSV for each part of each trial, and
/// in the end score.json and report.html.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "runtime/app/headless.h"
#include "runtime/exercise/exercise.h"

namespace beatlas::app {

struct KeptTrial {
  std::vector<std::string> parts;  ///< names of files in the folder
  double played_s = 0;             ///< of all parts
  bool done = false;               ///< the last mark was made, or time was up
};

/// session.json (schemas/exercise_session.schema.json): what a replay needs beside the traces.
struct KeptSession {
  exercise::Exercise exercise;
  std::string package;            ///< file name
  std::string field_sha256;       ///< of the heart's field
  std::string map_sha256;         ///< of the wall's map
  std::uint64_t seed = 0;         ///< 0..2^53: what is hidden is drawn from it
  double heart_rate_per_min = 0;  ///< 0: the atlas's own
  std::vector<KeptTrial> trials;

  [[nodiscard]] bool finished() const noexcept {
    return static_cast<int>(trials.size()) == exercise.trial_count() && trials.back().done;
  }
};

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
