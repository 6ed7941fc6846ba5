#include "pipeline/build/build_atlas.h"

#include <utility>

#include "pipeline/build/incremental_build.h"
#include "pipeline/build/learned_prior.h"

namespace beatlas::build {

void build_atlas(Exam exam, const Recipe& recipe, const Scene& scene,
                 const std::filesystem::path& file, Listener& listener) {
  Orders orders;
  orders.recipe = recipe;
  note_prior(orders, nullptr);
  IncrementalBuild stages(listener, std::move(orders), std::nullopt);
  stages.import_made(std::move(exam), {});
  stages.make(scene, file);
}

}  // namespace beatlas::build
