#include "runtime/app/exercise_files.h"

#include <fstream>

#include "runtime/app/exercise_trial.h"
#include "runtime/app/text.h"
#include "runtime/base/error.h"
#include "runtime/base/json_object.h"
#include "runtime/base/json_text.h"

namespace beatlas::app {
namespace {

using nlohmann::json;

constexpr int kVersion = 1;
constexpr double kMostSeed = 0x1p53;  // a JSON number holds it exactly

std::string part_name(std::size_t trial, std::size_t part) {
  const std::string number = std::to_string(trial + 1);
  return "trial_" + std::string(number.size() < 3 ? 3 - number.size() : 0, '0') + number + "_" +
         std::to_string(part + 1) + ".csv";
}

KeptTrial trial_from_json(const json& entry, std::size_t number) {
  const std::string path = "/trials/" + std::to_string(number);
  JsonObject object(entry, path);
  KeptTrial trial;
  const json& parts = object.at("parts");
  object.read("played_s", trial.played_s, 0, 1e6);
  object.read("done", trial.done);
  object.finish();
  if (!parts.is_array()) throw_invalid(path + "/parts must be a list");
  for (std::size_t n = 0; n < parts.size(); ++n) {
    // A name of another kind could lead out of the folder.
    if (parts[n] != part_name(number, n)) {
      throw_invalid(path + "/parts/" + std::to_string(n) + " must be " + part_name(number, n));
    }
    trial.parts.push_back(part_name(number, n));
  }
  return trial;
}

}  // namespace

bool holds_session(const std::filesystem::path& folder) {
  std::error_code ignored;
  return std::filesystem::exists(folder / "session.json", ignored);
}

KeptSession read_session(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "session.json";
  const json document = read_json_file(file.string(), JsonComments::Refuse);
  try {
    KeptSession out;
    JsonObject object(document, "");
    int version = kVersion;
    object.read("version", version, kVersion, kVersion);
    out.exercise = exercise::exercise_from_json(object.at("exercise"));
    object.read("package", out.package);
    object.read("field_sha256", out.field_sha256);
    object.read("map_sha256", out.map_sha256);
    double seed = 0;
    object.read("seed", seed, 0, kMostSeed);
    out.seed = static_cast<std::uint64_t>(seed);
    object.read("heart_rate_per_min", out.heart_rate_per_min, 0, 300);
    const json& trials = object.at("trials");
    object.finish();
    if (!trials.is_array() ||
        trials.size() > static_cast<std::size_t>(out.exercise.trial_count())) {
      throw_invalid("/trials must be a list of at most " +
                    std::to_string(out.exercise.trial_count()));
    }
    for (std::size_t n = 0; n < trials.size(); ++n) {
      if (n > 0 && !out.trials.back().done) {
        throw_invalid("/trials/" + std::to_string(n - 1) +
                      "/done must be true of all but the last");
      }
      out.trials.push_back(trial_from_json(trials[n], n));
    }
    return out;
  } catch (const Error& error) {
    throw error.with_context(file.string());
  }
}

void write_session(const KeptSession& session, const std::filesystem::path& folder) {
  json trials = json::array();
  for (const KeptTrial& trial : session.trials) {
    trials.push_back({{"parts", trial.parts}, {"played_s", trial.played_s}, {"done", trial.done}});
  }
  const json document = {{"version", kVersion},
                         {"exercise", exercise::exercise_to_json(session.exercise)},
                         {"package", session.package},
                         {"field_sha256", session.field_sha256},
                         {"map_sha256", session.map_sha256},
                         {"seed", session.seed},
                         {"heart_rate_per_min", session.heart_rate_per_min},
                         {"trials", std::move(trials)}};
  write_file(folder / "session.json", json_text(document, 2) + "\n");
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
