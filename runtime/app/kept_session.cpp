#include "runtime/app/kept_session.h"

#include <cmath>
#include <initializer_list>

#include "runtime/base/error.h"
#include "runtime/base/json_object.h"
#include "runtime/base/json_text.h"

namespace beatlas::app {
namespace {

using nlohmann::json;

constexpr int kVersion = 1;
constexpr double kMostSeed = 0x1p53;  // a JSON number holds it exactly

void demand(JsonObject& object, std::initializer_list<const char*> keys) {
  for (const char* key : keys) (void)object.at(key);
}

KeptTrial trial_from_json(const json& entry, std::size_t number) {
  const std::string path = "/trials/" + std::to_string(number);
  JsonObject object(entry, path);
  KeptTrial trial;
  demand(object, {"parts", "played_s", "done"});
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

KeptSession session_from_json(const json& document) {
  KeptSession out;
  JsonObject object(document, "");
  demand(object, {"version", "exercise", "package", "field_sha256", "map_sha256", "seed",
                  "heart_rate_per_min", "trials"});
  int version = kVersion;
  object.read("version", version, kVersion, kVersion);
  out.exercise = exercise::exercise_from_json(object.at("exercise"), "/exercise");
  object.read("package", out.package);
  object.read("field_sha256", out.field_sha256);
  object.read("map_sha256", out.map_sha256);
  double seed = 0;
  object.read("seed", seed, 0, kMostSeed);
  if (seed != std::floor(seed)) throw_invalid("/seed must be a whole number");
  out.seed = static_cast<std::uint64_t>(seed);
  object.read("heart_rate_per_min", out.heart_rate_per_min, 0, 300);
  const json& trials = object.at("trials");
  object.finish();
  if (!trials.is_array() || trials.size() > static_cast<std::size_t>(out.exercise.trial_count())) {
    throw_invalid("/trials must be a list of at most " +
                  std::to_string(out.exercise.trial_count()));
  }
  for (std::size_t n = 0; n < trials.size(); ++n) {
    if (n > 0 && !out.trials.back().done) {
      throw_invalid("/trials/" + std::to_string(n - 1) + "/done must be true of all but the last");
    }
    out.trials.push_back(trial_from_json(trials[n], n));
  }
  return out;
}

}  // namespace

std::string part_name(std::size_t trial, std::size_t part) {
  const std::string number = std::to_string(trial + 1);
  return "trial_" + std::string(number.size() < 3 ? 3 - number.size() : 0, '0') + number + "_" +
         std::to_string(part + 1) + ".csv";
}

KeptSession kept_session_from_text(std::string_view text, const std::string& name) {
  const json document = parse_json(text);
  if (document.is_discarded()) throw_invalid(name + " is not valid JSON");
  try {
    return session_from_json(document);
  } catch (const Error& error) {
    throw error.with_context(name);
  }
}

std::string kept_session_text(const KeptSession& session) {
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
  return json_text(document, 2) + "\n";
}

}  // namespace beatlas::app
