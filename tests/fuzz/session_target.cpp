// session.json of an exercise that is played.
#include "runtime/app/kept_session.h"
#include "tests/fuzz/fuzz_target.h"

namespace beatlas::fuzz {
namespace {

app::KeptSession of_task(exercise::Task task) {
  app::KeptSession out;
  out.exercise.task = task;
  out.exercise.title = "Find it";
  out.exercise.segments = {7, 12};
  if (task == exercise::Task::Threshold) out.exercise.kinds = {exercise::LesionKind::Soft};
  out.package = "heart.beatlas";
  out.field_sha256 = "ab";
  out.map_sha256 = "cd";
  out.seed = std::uint64_t{1} << 53U;
  out.heart_rate_per_min = 72.5;
  return out;
}

}  // namespace

std::vector<std::string> seeds() {
  const app::KeptSession begun = of_task(exercise::Task::Find);
  app::KeptSession done = begun;
  done.trials = {
      {.parts = {app::part_name(0, 0), app::part_name(0, 1)}, .played_s = 60.001, .done = true}};
  app::KeptSession broken_off = of_task(exercise::Task::Threshold);
  for (std::size_t n = 0; n < 3; ++n) {
    broken_off.trials.push_back({.parts = {app::part_name(n, 0)}, .played_s = 1e-3, .done = n < 2});
  }
  std::vector<std::string> out;
  for (const app::KeptSession& session : {begun, done, broken_off}) {
    out.push_back(app::kept_session_text(session));
    // Sound, or most of the reader is never reached.
    (void)app::kept_session_from_text(out.back(), "session.json");
  }
  return out;
}
std::vector<std::string> tokens() {
  return json_tokens({"true", "0.5", "\\u0000", "\xff", "../", "trial_001_1.csv", "\"trials\":",
                      "\"threshold\"", R"({"parts": [], "played_s": 0, "done": true},)"});
}
}  // namespace beatlas::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace beatlas;
  const std::string name = "session.json";
  try {
    const app::KeptSession session = app::kept_session_from_text(fuzz::text(data, size), name);
    for (std::size_t n = 0; n < session.trials.size(); ++n) {
      const std::vector<std::string>& parts = session.trials[n].parts;
      for (std::size_t part = 0; part < parts.size(); ++part) {
        // No file but those that a session writes, or it could lead out of its folder.
        fuzz::require(parts[part] == app::part_name(n, part));
      }
      fuzz::require(session.trials[n].done || n + 1 == session.trials.size());
    }
    (void)session.finished();
    const std::string text = app::kept_session_text(session);
    fuzz::require(app::kept_session_text(app::kept_session_from_text(text, name)) == text);
  } catch (const Error& error) {
    fuzz::require(error.code() == ErrorCode::InvalidInput);
    fuzz::require(std::string_view(error.what()).starts_with(name));
  }
  return 0;
}
