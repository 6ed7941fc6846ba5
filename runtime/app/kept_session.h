#pragma once
/// session.json (schemas/exercise_session.schema.json): what an exercise that is played keeps of
/// itself beside the traces of its trials.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/exercise/exercise.h"

namespace beatlas::app {

struct KeptTrial {
  std::vector<std::string> parts;  ///< names of files in the folder
  double played_s = 0;             ///< of all parts
  bool done = false;               ///< the last mark was made, or time was up
};

/// What a replay needs beside the traces.
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

/// The file of a trial's part, both counted from 0: a session names no other.
[[nodiscard]] std::string part_name(std::size_t trial, std::size_t part);

/// @param name of the file, for messages
/// @throws Error{InvalidInput} naming it, and the JSON path of what is missing, unknown or out of
/// range
[[nodiscard]] KeptSession kept_session_from_text(std::string_view text, const std::string& name);
/// Ends with a newline.
[[nodiscard]] std::string kept_session_text(const KeptSession& session);

}  // namespace beatlas::app
