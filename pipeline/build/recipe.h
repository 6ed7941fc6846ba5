#pragma once
/// A recipe: the options of every stage, as JSON. Defaults stand in the stages' own structs.

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "pipeline/assess/figures.h"
#include "pipeline/field/field.h"
#include "pipeline/ingest/ingest.h"
#include "pipeline/mesh/mesh.h"
#include "pipeline/motion/slice_shifts.h"
#include "pipeline/pack/pack.h"
#include "pipeline/segment/options.h"
#include "pipeline/shape/workspace.h"
#include "pipeline/study/study.h"

namespace beatlas::build {

/// What a package must reach; below it the exit code is 4 and no package is written.
struct QualityOptions {
  /// [%] 0.1..100: largest difference, over structures and phases, between the volume of the
  /// segmentation and that of the field or surface made from it, as a share of the structure's
  /// largest volume in the beat.
  double max_volume_gap_percent = 30;
};

struct Recipe {
  ingest::IngestOptions import;
  motion::AlignOptions align;
  segment::SegmentOptions segment;
  shape::RegisterOptions registration;
  field::FieldOptions field;
  mesh::MeshOptions mesh;
  pack::EncodeOptions pack;
  QualityOptions quality;
  assess::LimitSet validate;  ///< of `beatlas validate --truth`; a limit that is null is none
};

/// Strict: a missing key keeps its default. See schemas/recipe.schema.json.
/// @throws Error{InvalidInput} naming the JSON path of an unknown key, a wrong type or range.
[[nodiscard]] Recipe recipe_from_json(const nlohmann::json& json);
/// Every option with its value; recipe_from_json of it gives the same recipe.
[[nodiscard]] nlohmann::json recipe_to_json(const Recipe& recipe);
/// The part of recipe_to_json that a stage obeys; empty for Pictures.
[[nodiscard]] nlohmann::json stage_options(const Recipe& recipe, study::Stage stage);

/// @throws Error{InvalidInput} naming the file.
[[nodiscard]] Recipe read_recipe(const std::filesystem::path& file);

/// A recipe for an exam that is known: its own in all but what tells of the exam, of how its images
/// are taken (all of `import`) and of the model that knows such hearts (`segment/prior`); what it
/// does not name of that stays as it was.
/// @throws as recipe_from_json
[[nodiscard]] Recipe recipe_for_exam(const nlohmann::json& json, const Recipe& before);
/// @throws as read_recipe
[[nodiscard]] Recipe read_recipe_for_exam(const std::filesystem::path& file, const Recipe& before);
/// What was told of the exam and is another now: each as JSON path and former value.
[[nodiscard]] std::vector<std::string> replaced_of_exam(const Recipe& before, const Recipe& now);

}  // namespace beatlas::build
