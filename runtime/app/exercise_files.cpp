#include "runtime/app/exercise_files.h"

#include <fstream>

#include "runtime/app/text.h"

namespace beatlas::app {

bool holds_session(const std::filesystem::path& folder) {
  std::error_code ignored;
  return std::filesystem::exists(folder / "session.json", ignored);
}

KeptSession read_session(const std::filesystem::path& folder) {
  const std::string file = (folder / "session.json").string();
  return kept_session_from_text(read_text(file), file);
}

void write_session(const KeptSession& session, const std::filesystem::path& folder) {
  write_file(folder / "session.json", kept_session_text(session));
}

void keep_part(const std::vector<TraceRow>& trace, bool done, const std::filesystem::path& folder,
               std::size_t trial, KeptSession& session) {
  if (session.trials.size() <= trial) session.trials.resize(trial + 1);
  KeptTrial& kept = session.trials[trial];
  const std::string name = part_name(trial, kept.parts.size());
  write_file(folder / name, trace_csv(trace));
  kept.parts.push_back(name);
  if (!trace.empty()) kept.played_s += trace.back().time_s - trace.front().time_s;
  kept.done = done;
  write_session(session, folder);
}

std::vector<std::vector<TraceRow>> read_parts(const std::filesystem::path& folder,
                                              const KeptTrial& trial) {
  std::vector<std::vector<TraceRow>> out;
  for (const std::string& part : trial.parts) {
    const std::string file = (folder / part).string();
    std::ifstream stream = open_text(file);
    out.push_back(read_trace(stream, file));
  }
  return out;
}

}  // namespace beatlas::app
