#include "pipeline/build/made_package.h"

#include <set>
#include <system_error>
#include <vector>

#include "pipeline/build/report_facts.h"
#include "pipeline/study/files.h"
#include "runtime/base/error.h"
#include "runtime/base/replace_file.h"

namespace beatlas::build {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

constexpr auto kEnding = ".beatlas";

const study::StageRecord* record_of(const study::Study& study) {
  const study::StageRecord* record = study.find(study::Stage::Pack);
  return record == nullptr || record->package_sha256.empty() ? nullptr : record;
}

[[noreturn]] void ask_for_name(const std::string& why) {
  throw Error(ErrorCode::Usage, why + "; name the package to write with -o X.beatlas");
}

/// Whether a folder is a study, other than `study`, that made the same package last: its copy, the
/// one that it is a copy of, or one made alike.
bool is_twin(const fs::path& folder, const study::Study& study, const std::string& sha256) {
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored)) return false;
  if (fs::equivalent(folder, study.folder(), ignored)) return false;
  try {
    const study::Study other = study::Study::open(folder);
    const study::StageRecord* record = record_of(other);
    return record != nullptr && record->package_sha256 == sha256;
  } catch (const Error&) {  // no study, or one that cannot be read
    return false;
  }
}

}  // namespace

fs::path made_package(const study::Study& study) {
  const study::StageRecord* record = record_of(study);
  const std::string named = "the study " + study.folder().string();
  if (record == nullptr) ask_for_name(named + " has made no package yet");
  std::error_code ignored;
  const fs::path folder = fs::weakly_canonical(study.folder(), ignored);
  std::set<fs::path> found;
  std::set<fs::path> twins;
  const auto look_in = [&](const fs::path& place) {
    for (auto it = fs::directory_iterator(place, ignored); it != fs::directory_iterator();
         it.increment(ignored)) {
      const fs::path& file = it->path();
      if (is_twin(file, study, record->package_sha256)) twins.insert(file);
      // What a kill left half written beside the package may be a copy of it.
      if (file.extension() != kEnding || is_partial(file)) continue;
      if (!it->is_regular_file(ignored)) continue;
      if (study::holds(file, record->package_sha256)) {
        found.insert(fs::weakly_canonical(file, ignored));
      }
    }
  };
  look_in(folder);
  // What lies in the study is its own, whatever lies beside it.
  if (found.size() == 1) return *found.begin();
  look_in(folder.parent_path());
  look_in(fs::current_path(ignored));
  if (found.empty()) {
    ask_for_name("the package that " + named + " made last lies neither in it nor beside it");
  }
  if (found.size() > 1) {
    ask_for_name("there are " + std::to_string(found.size()) + " copies of the package that " +
                 named + " made last, " + found.begin()->string() + " and " +
                 std::next(found.begin())->string());
  }
  if (!twins.empty()) {
    ask_for_name("the package " + found.begin()->string() + " is what " + named +
                 " made last, and what " + twins.begin()->string() +
                 " made last, of which one may be a copy of the other");
  }
  return *found.begin();
}

Scene made_scene(const study::Study& study) {
  try {
    const json& told = record_of(study)->options.at("scene");
    Scene scene{told.at("content").get<std::string>(),
                told.at("stiffness_n_per_m").get<double>(),
                told.value("surface_edges_mm", std::vector<double>()),
                {}};
    for (const json& name : told.value("structures", json::array())) {
      if (const auto known = structure_from_name(name.get<std::string>())) {
        scene.structures.push_back(*known);
      }
    }
    return scene;
  } catch (const json::exception&) {
    throw_invalid((study.folder() / "study.json").string() +
                  ": /stages/pack/options/scene is not what it was made as; name the scene");
  }
}

}  // namespace beatlas::build
