#include "pipeline/build/orders.h"

#include <span>

#include "pipeline/build/learned_prior.h"
#include "pipeline/build/seeds.h"
#include "pipeline/build/version.h"
#include "pipeline/study/files.h"
#include "runtime/base/error.h"
#include "runtime/base/sha256.h"

namespace beatlas::build {
using study::Stage;
namespace {

constexpr auto kSeeds = "seeds";
constexpr auto kPainted = "painted";
constexpr auto kLabels = "labels";
constexpr auto kCoverage = "coverage_";  // of a structure

std::string coverage_key(Structure structure) {
  return kCoverage + std::string(structure_name(structure));
}

/// Where labels came from, by hash alone.
nlohmann::json told_of(const study::GivenLabels& given) {
  nlohmann::json out{{"sha256", given.sha256}, {"file_sha256", given.file_sha256}};
  if (!given.phases.empty()) out["phases"] = given.phases;
  return out;
}

}  // namespace

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
  const auto given = [&](const char* name, std::optional<study::GivenLabels>& labels) {
    const nlohmann::json& all = study.given();
    if (!all.contains(name)) return;
    const std::string path = std::string("/given/") + name;
    try {
      labels = study::read_given(study.folder(), all.at(name), path);
    } catch (const Error& error) {
      throw study::said_of(index, error);
    }
  };
  given(kPainted, out.painted);
  given(kLabels, out.labels);
  for (const Structure structure : kAllStructures) {
    const std::string key = coverage_key(structure);
    if (!study.given().contains(key)) continue;
    try {
      out.coverage[structure] =
          study::read_given_images(study.folder(), study.given().at(key), "/given/" + key);
    } catch (const Error& error) {
      throw study::said_of(index, error);
    }
  }
  out.labels_from = index + ": /given/labels";
  out.coverage_from = index + ": /given";
  if (out.painted) out.seeds_from = index + ": /given/painted";
  out.keeps_seeds = !out.seeds.empty() || out.painted;
  out.keeps_labels = out.labels.has_value();
  note_prior(out, &study);
  return out;
}

void keep_orders(const Orders& orders, study::Study& study) {
  study.set_recipe(recipe_to_json(orders.recipe));
  study.set_seeds(orders.seeds.empty() ? std::nullopt : std::optional(seeds_to_json(orders.seeds)));
  nlohmann::json given = nlohmann::json::object();
  if (orders.painted) given[kPainted] = study::write_given(study.folder(), *orders.painted);
  if (orders.labels) given[kLabels] = study::write_given(study.folder(), *orders.labels);
  for (const auto& [structure, images] : orders.coverage) {
    given[coverage_key(structure)] = study::write_given(study.folder(), images);
  }
  study::clear_given(study.folder(), {study.given(), given});
  study.set_given(std::move(given));
}

study::Wanted wanted_of(Stage stage, const Orders& orders) {
  study::Wanted out;
  out.version = kVersion;
  out.sources_sha256 = sources_sha256();
  out.options = stage_options(orders.recipe, stage);
  if (stage == Stage::Segment) out.options[kPriorOption] = orders.prior_sha256;
  if (stage == Stage::Segment && !orders.seeds.empty()) {
    const std::string text = seeds_to_json(orders.seeds).dump();
    out.options[kSeeds] = {{"count", orders.seeds.size()},
                           {"sha256", sha256_hex(std::as_bytes(std::span(text)))}};
  }
  if (stage == Stage::Segment && orders.painted) out.options[kPainted] = told_of(*orders.painted);
  if (stage == Stage::Segment && orders.labels) out.options[kLabels] = told_of(*orders.labels);
  if (stage == Stage::Segment) {
    for (const auto& [structure, images] : orders.coverage) {
      out.options[coverage_key(structure)] = {{"sha256", images.sha256},
                                              {"file_sha256", images.file_sha256}};
    }
  }
  return out;
}

}  // namespace beatlas::build
