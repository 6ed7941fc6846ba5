#include "runtime/exercise/exercise.h"

#include <algorithm>
#include <array>
#include <functional>

#include "runtime/base/error.h"
#include "runtime/base/json_object.h"
#include "runtime/palpation/parameters.h"
#include "runtime/palpation/segments.h"

namespace beatlas::exercise {
namespace {

using nlohmann::json;

constexpr int kVersion = 1;
constexpr std::array<std::string_view, kLesionKinds> kNames{"soft", "thin", "akinetic", "scar"};
/// A wall is at least 0.3 of a healthy one's thickness (palpation::Tissue).
constexpr double kMostThinning = 0.7;
constexpr int kNone = -1;

void read_range(JsonObject& object, const std::string& key, Range& range, double low, double high) {
  if (!object.has(key)) return;
  std::vector<double> ends;
  object.read(key, ends, low, high);
  if (ends.size() != 2 || ends[0] > ends[1]) {
    throw_invalid(object.path() + "/" + key + " must be two numbers, the smaller one first");
  }
  range = {ends[0], ends[1]};
}

/// A list of words, each once, as the numbers that `find` knows them by. @return empty where the
/// key is not there
std::vector<int> read_words(JsonObject& object, const std::string& key,
                            const std::function<int(const std::string&)>& find,
                            const std::string& known) {
  std::vector<int> out;
  if (!object.has(key)) return out;
  const json& list = object.at(key);
  const std::string path = object.path() + "/" + key;
  if (!list.is_array() || list.empty()) throw_invalid(path + " must be a list of one word or more");
  for (std::size_t n = 0; n < list.size(); ++n) {
    const int found = list[n].is_string() ? find(list[n].get<std::string>()) : kNone;
    const std::string where = path + "/" + std::to_string(n);
    if (found == kNone) throw_invalid(where + " is none of " + known);
    if (std::find(out.begin(), out.end(), found) != out.end()) {
      throw_invalid(where + " is there twice");
    }
    out.push_back(found);
  }
  return out;
}

int kind_from_name(const std::string& name) {
  const auto found = std::find(kNames.begin(), kNames.end(), name);
  return found == kNames.end() ? kNone : static_cast<int>(found - kNames.begin());
}

void read_find(JsonObject& object, Exercise& out) {
  const std::vector<int> kinds =
      read_words(object, "kinds", kind_from_name, "soft, thin, akinetic, scar");
  if (!kinds.empty()) out.kinds.clear();
  for (const int kind : kinds) out.kinds.push_back(static_cast<LesionKind>(kind));
  read_range(object, "grade", out.grade, 0.05, 1);
  object.read("lesions", out.lesions, 1, 3);
  const bool softens = std::any_of(out.kinds.begin(), out.kinds.end(), [](LesionKind kind) {
    return kind == LesionKind::Soft || kind == LesionKind::Thin;
  });
  if (softens && out.grade.high > kMostThinning) {
    throw_invalid(object.path() +
                  "/grade must end at 0.7 or before where a lesion may be soft or thin");
  }
}

void read_threshold(JsonObject& object, Exercise& out) {
  out.kinds = {LesionKind::Soft};
  object.read("trials", out.trials, 5, 200);
  object.read("places", out.places, 2, 8);
  object.read("first_difference", out.first_difference, 0.05, 0.4);
}

}  // namespace

std::string_view lesion_name(LesionKind kind) noexcept {
  return kNames[static_cast<std::size_t>(kind)];
}

Exercise exercise_from_json(const json& document, const std::string& path) {
  Exercise out;
  JsonObject object(document, path);
  int version = kVersion;
  object.read("version", version, kVersion, kVersion);
  object.read("title", out.title);
  object.read("preset", out.preset);
  const std::vector<std::string> presets = palpation::palpation_presets();
  if (std::find(presets.begin(), presets.end(), out.preset) == presets.end()) {
    throw_invalid(path +
                  "/preset must be healthy, anterior_infarct or another of beatlas-play --preset");
  }
  std::string task = "find";
  object.read("task", task);
  if (task != "find" && task != "threshold")
    throw_invalid(path + "/task must be find or threshold");
  out.task = task == "find" ? Task::Find : Task::Threshold;
  out.segments = read_words(
      object, "segments",
      [](const std::string& name) { return palpation::segment_from_name(name).value_or(kNone); },
      palpation::segment_names());
  read_range(object, "radius_mm", out.radius_mm, 4, 40);
  object.read("seconds", out.seconds, 5, 1800);
  object.read("tool_radius_mm", out.tool_radius_mm, 0, 20);
  object.read("harmful_force_n", out.harmful_force_n, 0, 50);
  out.task == Task::Find ? read_find(object, out) : read_threshold(object, out);
  object.finish();
  return out;
}

json exercise_to_json(const Exercise& exercise) {
  json out = {{"version", kVersion},
              {"title", exercise.title},
              {"preset", exercise.preset},
              {"task", exercise.task == Task::Find ? "find" : "threshold"},
              {"radius_mm", {exercise.radius_mm.low, exercise.radius_mm.high}},
              {"seconds", exercise.seconds},
              {"tool_radius_mm", exercise.tool_radius_mm},
              {"harmful_force_n", exercise.harmful_force_n}};
  if (!exercise.segments.empty()) {
    json& names = out["segments"] = json::array();
    for (const int segment : exercise.segments) names.push_back(palpation::segment_name(segment));
  }
  if (exercise.task == Task::Find) {
    json& names = out["kinds"] = json::array();
    for (const LesionKind kind : exercise.kinds) names.push_back(lesion_name(kind));
    out["grade"] = {exercise.grade.low, exercise.grade.high};
    out["lesions"] = exercise.lesions;
  } else {
    out["trials"] = exercise.trials;
    out["places"] = exercise.places;
    out["first_difference"] = exercise.first_difference;
  }
  return out;
}

}  // namespace beatlas::exercise
