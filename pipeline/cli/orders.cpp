#include "pipeline/cli/orders.h"

#include <span>

#include "pipeline/cli/seeds.h"
#include "pipeline/cli/version.h"
#include "runtime/base/error.h"
#include "runtime/base/sha256.h"

namespace beatlas::cli {
using study::Stage;

Orders orders_of(const study::Study& study) {
  Orders out;
  const std::string index = (study.folder() / "study.json").string();
  try {
    if (study.recipe()) out.recipe = recipe_from_json(*study.recipe());
  } catch (const Error& error) {
    throw error.with_context(index + ": /recipe");
  }
  try {
    out.seeds_from = index + ": /seeds";
    if (study.seeds()) out.seeds = seeds_from_json(*study.seeds());
  } catch (const Error& error) {
    throw error.with_context(out.seeds_from);
  }
  return out;
}

void keep_orders(const Orders& orders, study::Study& study) {
  study.set_recipe(recipe_to_json(orders.recipe));
  study.set_seeds(orders.seeds.empty() ? std::nullopt : std::optional(seeds_to_json(orders.seeds)));
}

void take_seeds(const std::string& word, Orders& orders) {
  orders.seeds = word == "none" ? std::vector<segment::Seed>{} : read_seeds(word);
  orders.seeds_from = word;
}

study::Wanted wanted_of(Stage stage, const Orders& orders) {
  study::Wanted out;
  out.version = kVersion;
  out.options = stage_options(orders.recipe, stage);
  if (stage == Stage::Segment && !orders.seeds.empty()) {
    const std::string text = seeds_to_json(orders.seeds).dump();
    out.options["seeds"] = {{"count", orders.seeds.size()},
                            {"sha256", sha256_hex(std::as_bytes(std::span(text)))}};
  }
  return out;
}

bool packed_with_surfaces(const study::StageRecord& record) {
  for (const auto& input : record.inputs) {
    if (input.first.starts_with("mesh/")) return true;
  }
  return false;
}

}  // namespace beatlas::cli
