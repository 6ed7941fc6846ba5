#include "runtime/atlas/scene.h"

#include <gtest/gtest.h>

#include "pipeline/build/scene_plan.h"
#include "runtime/base/error.h"

namespace beatlas::build {
namespace {

using enum Structure;
using List = std::vector<Structure>;

Scene of(const std::string& text) { return scene_from_json(nlohmann::json::parse(text)); }

TEST(StructuresNeeded, are_the_four_of_every_scene_that_is_known_by_name) {
  const List four{Heart, LvBlood, RvBlood, LvMyocardium};
  for (const std::string_view name : atlas::kScenes) {
    EXPECT_EQ(structures_needed(read_scene(std::string(name)), false), four) << name;
  }
  EXPECT_EQ(structures_needed(Scene(), false), four);
}

TEST(StructuresNeeded, are_those_that_the_scene_names) {
  const Scene scene = of(R"({"structures": ["lv_blood", "heart", "aorta"]})");
  const List named{Heart, LvBlood, Aorta};
  EXPECT_EQ(structures_needed(scene, false), named);
  EXPECT_EQ(structures_needed(scene, true), named);
}

TEST(StructuresNeeded, are_the_heart_alone_where_all_labels_were_given) {
  EXPECT_EQ(structures_needed(Scene(), true), List{Heart});
}

TEST(ScenePlan, holds_what_a_finger_touches_and_what_tells_of_the_muscle_under_it) {
  const ScenePlan plan = plan_of(read_scene("palpation"));
  EXPECT_EQ(plan.fields, (List{Heart, LvBlood, LvMyocardium}));
  EXPECT_EQ(plan.surfaces, List{LvBlood});
  EXPECT_FALSE(plan.atria);
  EXPECT_FALSE(plan.volume);
}

TEST(ScenePlan, holds_every_surface_where_all_is_seen) {
  const List all(kAllStructures.begin(), kAllStructures.end());
  for (const char* name : {"anatomy", "full"}) {
    SCOPED_TRACE(name);
    const ScenePlan plan = plan_of(read_scene(name));
    EXPECT_EQ(plan.surfaces, all);
    EXPECT_EQ(plan.fields, all);  // surfaces are made from them
    EXPECT_TRUE(plan.atria);
    EXPECT_EQ(plan.volume, name == std::string("full"));
  }
}

TEST(ScenePlan, of_a_study_is_enough_for_any_scene) {
  for (const std::string_view name : atlas::kScenes) {
    SCOPED_TRACE(name);
    const Scene scene = read_scene(std::string(name));
    const ScenePlan study = plan_of_study(scene);
    for (const std::string_view other : atlas::kScenes) {
      const ScenePlan plan = plan_of(read_scene(std::string(other)));
      for (const Structure each : plan.fields) EXPECT_TRUE(is_among(each, study.fields));
      for (const Structure each : plan.surfaces) EXPECT_TRUE(is_among(each, study.surfaces));
      EXPECT_TRUE(study.atria);
    }
    EXPECT_EQ(study.volume, plan_of(scene).volume);
  }
}

TEST(SceneFromJson, refuses_structures_that_are_none_by_their_place) {
  const auto refusal = [](const std::string& text) -> std::string {
    try {
      (void)of(text);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
      return error.what();
    }
    return "(accepted)";
  };
  EXPECT_EQ(refusal(R"({"structures": ["heart"]})"), "(accepted)");
  EXPECT_NE(refusal(R"({"structures": []})").find("/structures"), std::string::npos);
  EXPECT_NE(refusal(R"({"structures": "heart"})").find("/structures"), std::string::npos);
  EXPECT_NE(refusal(R"({"structures": ["heart", "spleen"]})").find("/structures/1"),
            std::string::npos);
  EXPECT_NE(refusal(R"({"structures": ["heart", "heart"]})").find("/structures/1"),
            std::string::npos);
}

TEST(SceneToJson, keeps_what_a_record_of_one_without_structures_had) {
  EXPECT_EQ(scene_to_json(Scene()).size(), 3U);
  EXPECT_EQ(scene_to_json(of(R"({"structures": ["heart"]})")).at("structures"),
            nlohmann::json::array({"heart"}));
}

}  // namespace
}  // namespace beatlas::build
