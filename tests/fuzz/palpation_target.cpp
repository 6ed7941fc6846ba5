// What users write about muscle, circulation, regions and exercises of the palpation trainer.
#include "runtime/base/json_text.h"
#include "runtime/exercise/exercise.h"
#include "runtime/palpation/parameters.h"
#include "runtime/palpation/regions.h"
#include "tests/fuzz/fuzz_target.h"

namespace beatlas::fuzz {
std::vector<std::string> seeds() {
  const auto regions = parse_json(
      R"([{"painted": "scar.csv", "label": 2, "scar": 0.8, "thickness_ratio": 0.6},
          {"thinner_than_mm": 5, "scar": 0.5}])");
  (void)palpation::regions_from_json(regions);  // sound, or most of the reader is never reached
  std::vector<std::string> out;
  for (const std::string& name : palpation::palpation_presets()) {
    out.push_back(json_text(palpation::palpation_to_json(palpation::palpation_preset(name)), 1));
  }
  nlohmann::json with = parse_json(out.front());
  with["regions"] = regions;
  out.push_back(json_text(with));
  out.emplace_back("{} // nothing told");
  for (const exercise::Task task : {exercise::Task::Find, exercise::Task::Threshold}) {
    exercise::Exercise asked;
    asked.task = task;
    asked.segments = {7, 12};
    out.push_back(json_text(exercise::exercise_to_json(asked), 1));
  }
  return out;
}
std::vector<std::string> tokens() {
  return json_tokens({"\"regions\":", "\"segments\":", "\"tissue\":", "//", "/*"});
}
}  // namespace beatlas::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace beatlas;
  const nlohmann::json json = parse_json(fuzz::text(data, size), JsonComments::Skip);
  if (json.is_discarded()) return 0;
  fuzz::only_errors([&] {
    const auto parameters = palpation::palpation_from_json(json);
    parameters.check();
    const nlohmann::json again = palpation::palpation_to_json(parameters);
    fuzz::require(palpation::palpation_to_json(palpation::palpation_from_json(again)) == again);
  });
  fuzz::only_errors([&] {
    const nlohmann::json again = exercise::exercise_to_json(exercise::exercise_from_json(json));
    fuzz::require(exercise::exercise_to_json(exercise::exercise_from_json(again)) == again);
  });
  if (!json.is_object() || !json.contains("regions")) return 0;
  fuzz::only_errors([&] {
    const nlohmann::json again =
        palpation::regions_to_json(palpation::regions_from_json(json["regions"]));
    fuzz::require(palpation::regions_to_json(palpation::regions_from_json(again)) == again);
  });
  return 0;
}
