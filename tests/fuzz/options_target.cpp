// JSON that users write: recipes, seeds, scenes. The first byte says which.
#include "pipeline/cli/recipe.h"
#include "pipeline/cli/scene.h"
#include "pipeline/cli/seeds.h"
#include "tests/fuzz/fuzz_target.h"

namespace beatlas::fuzz {
std::vector<std::string> seeds() {
  return {"r" + cli::recipe_to_json({}).dump(1), "r{}",
          R"(s{"seeds": [{"structure": "lv_blood", "phase": 0, "lps_mm": [1, -2.5, 3]},
              {"label": "background", "phase": 1, "lps_mm": [1, 2, 3], "radius_mm": 4}]})",
          R"(c{"content": "palpation", "stiffness_n_per_m": 200})"};
}
std::vector<std::string> tokens() {
  return {"{", "}", "[", "]", "\"", ":", ",", "null", "1e400", "-0", "[[[[[[[[", "\\ud800"};
}
}  // namespace beatlas::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace beatlas;
  if (size == 0) return 0;
  static const fuzz::MemoryFolder folder;
  const auto file = folder.write("a.json", fuzz::text(data + 1, size - 1));
  fuzz::only_errors([&] {
    if (data[0] == 'r') {
      const cli::Recipe recipe = cli::read_recipe(file);
      (void)cli::recipe_from_json(cli::recipe_to_json(recipe));
    } else if (data[0] == 's') {
      (void)cli::seeds_from_json(cli::seeds_to_json(cli::read_seeds(file)));
    } else {
      (void)cli::read_scene(file.string());
    }
  });
  return 0;
}
