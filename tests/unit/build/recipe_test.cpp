#include "pipeline/build/recipe.h"

#include <gtest/gtest.h>

#include "pipeline/build/scene.h"
#include "pipeline/build/seeds.h"
#include "runtime/base/error.h"
#include "runtime/base/json_text.h"

namespace beatlas::build {
namespace {
using nlohmann::json;

template <class Action>
std::string refusal(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
    return error.what();
  }
  return "(accepted)";
}

std::string recipe_refusal(const char* text) {
  return refusal([&] { (void)recipe_from_json(parse_json(text)); });
}

TEST(Recipe, DefaultsAreThoseOfTheStructs) {
  const Recipe recipe = recipe_from_json(json::object());
  EXPECT_EQ(recipe.field.voxel_mm, field::FieldOptions{}.voxel_mm);
  EXPECT_EQ(recipe.mesh.edge_mm, mesh::MeshOptions{}.edge_mm);
  EXPECT_EQ(recipe.registration.shape_mm, shape::RegisterOptions{}.shape_mm);
  EXPECT_EQ(recipe.pack.step_mm, pack::EncodeOptions{}.step_mm);
}

TEST(Recipe, GoesThroughJsonUnchanged) {
  json changed = recipe_to_json({});
  for (auto& section : changed.items()) {
    for (auto& option : section.value().items()) {
      // Still in range for every option: the defaults are not at both ends.
      if (option.value().is_number_float()) option.value() = option.value().get<double>() * 1.01;
    }
  }
  changed["import"]["phases"] = 20;
  EXPECT_EQ(recipe_to_json(recipe_from_json(changed)), changed);
}

TEST(Recipe, WhatItDoesNotNameKeepsItsDefault) {
  const Recipe recipe = recipe_from_json(parse_json(R"({"mesh": {"edge_mm": 3}})"));
  EXPECT_EQ(recipe.mesh.edge_mm, 3);
  EXPECT_EQ(recipe.mesh.reference_phase, mesh::MeshOptions{}.reference_phase);
}

TEST(Recipe, WhatWasToldOfTheExamStaysUntilARecipeNamesIt) {
  Recipe before;
  before.import.rr_interval_s = 0.8;
  before.import.series = {3, 5};
  before.segment.prior = "m.onnx";
  before.align.slices = motion::AlignOptions::Slices::Off;
  before.mesh.edge_mm = 3;
  const Recipe now = recipe_for_exam(
      parse_json(R"({"segment": {"papillary": "muscle"}, "import": {"series": [7]}})"), before);
  EXPECT_EQ(now.import.rr_interval_s, 0.8);
  EXPECT_EQ(now.import.series, std::vector<int>{7});
  EXPECT_EQ(now.segment.prior, "m.onnx");
  EXPECT_EQ(now.segment.papillary, segment::Papillary::Muscle);
  EXPECT_EQ(now.align.slices, motion::AlignOptions::Slices::Off);
  EXPECT_EQ(now.mesh.edge_mm, mesh::MeshOptions{}.edge_mm);
  EXPECT_EQ(replaced_of_exam(before, now), std::vector<std::string>{"/import/series"});
  const Recipe other = recipe_for_exam(parse_json(R"({"import": {"rr_interval_s": 0.9}})"), now);
  EXPECT_EQ(replaced_of_exam(now, other), std::vector<std::string>{"/import/rr_interval_s 0.8"});
  EXPECT_TRUE(replaced_of_exam({}, other).empty());
  EXPECT_NE(refusal([&] {
              (void)recipe_for_exam(parse_json(R"({"import": []})"), before);
            }).find("/import"),
            std::string::npos);
}

TEST(Recipe, WhatNothingAsksAnyMoreIsPassedOver) {
  const Recipe recipe = recipe_from_json(
      parse_json(R"({"segment": {"tricuspid_excursion_mm": 22, "atria": false}})"));
  EXPECT_FALSE(recipe.segment.atria);
  EXPECT_FALSE(recipe_to_json(recipe).at("segment").contains("tricuspid_excursion_mm"));
}

TEST(Recipe, HandlesWhereEarlierRecipesHadThemCountForTheField) {
  const Recipe old = recipe_from_json(parse_json(R"({"mesh": {"handles": "keep"}})"));
  EXPECT_EQ(old.field.handles, field::Handles::Keep);
  EXPECT_FALSE(recipe_to_json(old).at("mesh").contains("handles"));
  const Recipe both = recipe_from_json(
      parse_json(R"({"mesh": {"handles": "keep"}, "field": {"handles": "close"}})"));
  EXPECT_EQ(both.field.handles, field::Handles::Close);
  EXPECT_NE(recipe_refusal(R"({"mesh": {"handles": "cut"}})").find("/field/handles"),
            std::string::npos);
  EXPECT_NE(recipe_refusal(R"({"mesh": {"handles": "keep"}, "field": []})").find("/field"),
            std::string::npos);
}

TEST(Recipe, RefusalsNameThePath) {
  EXPECT_NE(recipe_refusal(R"({"mesh": {"edge": 1}})").find("/mesh/edge"), std::string::npos);
  EXPECT_NE(recipe_refusal(R"({"msh": {}})").find("/msh"), std::string::npos);
  EXPECT_NE(recipe_refusal(R"({"field": {"voxel_mm": 0.1}})").find("/field/voxel_mm"),
            std::string::npos);
  EXPECT_NE(recipe_refusal(R"({"field": {"voxel_mm": "1"}})").find("/field/voxel_mm"),
            std::string::npos);
  EXPECT_NE(recipe_refusal(R"({"mesh": {"reference_phase": 1.5}})").find("/mesh/reference_phase"),
            std::string::npos);
  EXPECT_NE(recipe_refusal(R"({"mesh": []})").find("/mesh"), std::string::npos);
  EXPECT_NE(recipe_refusal("[]"), "(accepted)");
}

TEST(Recipe, ALeakWarnsOrIsAnError) {
  EXPECT_EQ(recipe_from_json(json::object()).segment.leak.action, alarm::LeakAction::Warn);
  const Recipe strict = recipe_from_json(parse_json(R"({"segment": {"leak": "error"}})"));
  EXPECT_EQ(strict.segment.leak.action, alarm::LeakAction::Error);
  EXPECT_EQ(recipe_to_json(strict)["segment"]["leak"], "error");
  EXPECT_NE(recipe_refusal(R"({"segment": {"leak": "ring"}})").find("must be warn or error"),
            std::string::npos);
  EXPECT_NE(recipe_refusal(R"({"segment": {"leak": 1}})").find("/segment/leak"), std::string::npos);
}

TEST(Recipe, TheMethodAndThePapillaryMusclesAreChosenByName) {
  const segment::SegmentOptions plain = recipe_from_json(json::object()).segment;
  EXPECT_EQ(plain.method, segment::Method::Competition);
  EXPECT_EQ(plain.papillary, segment::Papillary::Cavity);
  const json other = parse_json(
      R"({"segment": {"method": "threshold", "papillary": "muscle", "threshold_low": 100,
          "threshold_high": 300.5, "threshold_neighbours": "all", "labels_drawn_on": "aligned"}})");
  const Recipe recipe = recipe_from_json(other);
  EXPECT_EQ(recipe.segment.method, segment::Method::Threshold);
  EXPECT_EQ(recipe.segment.papillary, segment::Papillary::Muscle);
  EXPECT_EQ(recipe.segment.labels_drawn_on, segment::LabelsDrawnOn::Aligned);
  EXPECT_EQ(recipe.segment.threshold_neighbours, segment::Neighbours::All);
  EXPECT_EQ(recipe.segment.threshold_high, 300.5);
  for (const auto& option : other["segment"].items()) {
    EXPECT_EQ(recipe_to_json(recipe)["segment"][option.key()], option.value());
  }
  EXPECT_NE(recipe_refusal(R"({"segment": {"method": "snake"}})")
                .find("must be competition or threshold"),
            std::string::npos);
  EXPECT_NE(recipe_refusal(R"({"segment": {"papillary": true}})").find("/segment/papillary"),
            std::string::npos);
}

TEST(Recipe, LimitsAreOfAllStructuresAndOfSingleOnes) {
  const Recipe recipe = recipe_from_json(parse_json(
      R"({"validate": {"max_rms_mm": 0.5, "min_dice": null,
          "structures": {"lv_blood": {"max_rms_mm": 0.2}}}})"));
  EXPECT_EQ(recipe.validate.all.max_rms_mm, 0.5);
  EXPECT_FALSE(recipe.validate.all.min_dice);
  EXPECT_EQ(recipe.validate.of(Structure::LvBlood).max_rms_mm, 0.2);
  EXPECT_EQ(recipe.validate.of(Structure::Heart).max_rms_mm, 0.5);
  EXPECT_EQ(recipe_to_json(recipe_from_json(recipe_to_json(recipe))), recipe_to_json(recipe));
  EXPECT_NE(recipe_refusal(R"({"validate": {"max_rms": 1}})").find("/validate/max_rms"),
            std::string::npos);
  EXPECT_NE(recipe_refusal(R"({"validate": {"structures": {"spleen": {}}}})")
                .find("/validate/structures/spleen"),
            std::string::npos);
  EXPECT_NE(recipe_refusal(R"({"validate": {"structures": {"heart": {"max_rms_mm": -1}}}})")
                .find("/validate/structures/heart/max_rms_mm"),
            std::string::npos);
}

TEST(Recipe, EveryStageFindsItsOptions) {
  for (study::Stage stage : study::kAllStages) {
    EXPECT_TRUE(stage_options({}, stage).is_object()) << study::stage_name(stage);
  }
}

TEST(Scene, NamesAndObjectsAreUnderstood) {
  EXPECT_EQ(read_scene("palpation").content, "palpation");
  const Scene scene = scene_from_json(
      parse_json(R"({"content": "anatomy", "material": {"stiffness_n_per_m": 80}})"));
  EXPECT_EQ(scene.content, "anatomy");
  EXPECT_EQ(scene.stiffness_n_per_m, 80);
  EXPECT_EQ(scene_from_json(json::object()).content, "full");
  // Levels of detail: as meshed and, where a viewer may want less, 4 mm; or as the scene says.
  using Edges = std::vector<double>;
  EXPECT_EQ(surface_edges_mm(scene, 2), (Edges{2, 4}));
  EXPECT_EQ(surface_edges_mm(scene, 3), Edges{3});
  EXPECT_EQ(surface_edges_mm(read_scene("palpation"), 2), Edges{2});
  const Scene levels = scene_from_json(parse_json(R"({"surface_edges_mm": [1, 2, 4]})"));
  EXPECT_EQ(surface_edges_mm(levels, 2), (Edges{1, 2, 4}));
}

TEST(Scene, RefusalsNameThePath) {
  const auto scene_refusal = [](const char* text) {
    return refusal([&] { (void)scene_from_json(parse_json(text)); });
  };
  EXPECT_NE(scene_refusal(R"({"content": "all"})").find("/content"), std::string::npos);
  EXPECT_NE(scene_refusal(R"({"material": {"stiffness": 1}})").find("/material/stiffness"),
            std::string::npos);
  EXPECT_NE(scene_refusal(R"({"material": {"stiffness_n_per_m": -1}})").find("stiffness_n_per_m"),
            std::string::npos);
  for (const char* edges : {"[]", "2", "[0.1]", "[11]", "[2, 2]", "[4, 2]", "[\"2\"]"}) {
    const std::string scene = std::string(R"({"surface_edges_mm": )") + edges + "}";
    EXPECT_NE(scene_refusal(scene.c_str()).find("/surface_edges_mm"), std::string::npos) << edges;
  }
  EXPECT_THROW((void)read_scene("everything"), Error);
}

TEST(Seeds, GoThroughJsonUnchanged) {
  const json text = parse_json(
      R"({"seeds": [{"label": 3, "lps_mm": [1.5, -2, 0.1], "radius_mm": 4.5, "phase": -1}]})");
  const std::vector<segment::Seed> seeds = seeds_from_json(text);
  ASSERT_EQ(seeds.size(), 1U);
  EXPECT_EQ(seeds[0].label, kLabelLvBlood);
  EXPECT_EQ(seeds[0].lps_mm, Vec3(1.5, -2, 0.1));
  EXPECT_EQ(seeds[0].phase, -1);
  EXPECT_EQ(seeds_from_json(seeds_to_json(seeds))[0].radius_mm, 4.5);
}

TEST(Seeds, RefusalsNameThePath) {
  const auto seeds_refusal = [](const char* text) {
    return refusal([&] { (void)seeds_from_json(parse_json(text)); });
  };
  EXPECT_NE(
      seeds_refusal(R"({"seeds": [{"label": 5, "lps_mm": [0, 0, 0]}]})").find("/seeds/0/label"),
      std::string::npos);
  EXPECT_NE(seeds_refusal(R"({"seeds": [{"lps_mm": [0, 0, 0]}]})").find("/seeds/0/label"),
            std::string::npos);
  EXPECT_NE(seeds_refusal(R"({"seeds": [{"label": 1, "lps_mm": [0, 0]}]})").find("/seeds/0/lps_mm"),
            std::string::npos);
  EXPECT_NE(seeds_refusal(R"({"seeds": []})").find("/seeds"), std::string::npos);
  EXPECT_NE(seeds_refusal(R"({})").find("/seeds"), std::string::npos);
}

}  // namespace
}  // namespace beatlas::build
