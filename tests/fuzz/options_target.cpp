// JSON that users write: recipes, seeds, scenes. The first byte says which.
#include "pipeline/build/recipe.h"
#include "pipeline/build/scene.h"
#include "pipeline/build/seeds.h"
#include "pipeline/cli/markups.h"
#include "pipeline/study/files.h"
#include "runtime/base/json_text.h"
#include "tests/fuzz/fuzz_target.h"

namespace beatlas::fuzz {
std::vector<std::string> seeds() {
  const auto drawn = parse_json(
      R"({"seeds": [{"label": 3, "lps_mm": [1, -2.5, 3], "phase": 0},
                    {"label": 0, "lps_mm": [10, 20, 30], "radius_mm": 4, "phase": -1},
                    {"label": 2, "stroke_lps_mm": [[1, 2, 3], [4, 5, 6]]}], "version": 1})");
  const auto markups = parse_json(
      R"({"@schema": "markups-schema-v1.0.3.json#",
          "markups": [{"type": "ClosedCurve", "name": "LV@2", "coordinateSystem": "RAS",
                       "coordinateUnits": ["um", "UCUM", "micrometer"], "labelFormat": "%N-%d",
                       "controlPoints": [{"label": "lv-1", "position": [1, -2.5, 3]},
                                         {"label": "3@2", "position": [1, 2, 3],
                                          "positionStatus": "defined"}]}]})");
  const auto scene =
      parse_json(R"({"content": "palpation", "material": {"stiffness_n_per_m": 200}})");
  (void)build::seeds_from_json(drawn);  // they must be sound, or most of a reader is never reached
  (void)cli::seeds_from_markups(markups, {});
  (void)build::scene_from_json(scene);
  return {"r" + json_text(build::recipe_to_json({}), 1), "r{}", "s" + json_text(drawn, 1),
          "s" + json_text(markups, 1), "c" + json_text(scene, 1)};
}
std::vector<std::string> tokens() { return json_tokens({"\\ud800"}); }
}  // namespace beatlas::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace beatlas;
  if (size == 0) return 0;
  static const fuzz::MemoryFolder folder;
  const auto file = folder.write("a.json", fuzz::text(data + 1, size - 1));
  fuzz::only_errors([&] {
    if (data[0] == 'r') {
      const build::Recipe recipe = build::read_recipe(file);
      (void)build::recipe_from_json(build::recipe_to_json(recipe));
    } else if (data[0] == 's') {
      const nlohmann::json marks = study::read_json(file);
      (void)build::seeds_from_json(build::seeds_to_json(cli::holds_markups(marks)
                                                            ? cli::seeds_from_markups(marks, {})
                                                            : build::seeds_from_json(marks)));
    } else {
      (void)build::read_scene(file.string());
    }
  });
  return 0;
}
