#include "runtime/atlas/scene.h"

#include <gtest/gtest.h>

#include "pipeline/build/scene_plan.h"
#include "runtime/base/error.h"
#include "runtime/base/json_text.h"

namespace beatlas::build {
namespace {

using enum Structure;
using List = std::vector<Structure>;

Scene of(const std::string& text) { return scene_from_json(parse_json(text)); }

TEST(StructuresNeeded, AreTheFourOfEverySceneThatIsKnownByName) {
  const List four{Heart, LvBlood, RvBlood, LvMyocardium};
  for (const std::string_view name : atlas::kScenes) {
    EXPECT_EQ(structures_needed(read_scene(std::string(name)), false), four) << name;
  }
  EXPECT_EQ(structures_needed(Scene(), false), four);
}

TEST(StructuresNeeded, AreThoseThatTheSceneNames) {
  const Scene scene = of(R"({"structures": ["lv_blood", "heart", "aorta"]})");
  const List named{Heart, LvBlood, Aorta};
  EXPECT_EQ(structures_needed(scene, false), named);
  EXPECT_EQ(structures_needed(scene, true), named);
}

TEST(StructuresNeeded, AreTheHeartAloneWhereAllLabelsWereGiven) {
  EXPECT_EQ(structures_needed(Scene(), true), List{Heart});
}

TEST(ScenePlan, HoldsWhatAFingerTouchesAndWhatTellsOfTheMuscleUnderIt) {
  const ScenePlan plan = plan_of(read_scene("palpation"));
  EXPECT_EQ(plan.fields, (List{Heart, LvBlood, LvMyocardium}));
  EXPECT_EQ(plan.surfaces, List{LvBlood});
  EXPECT_FALSE(plan.atria);
  EXPECT_FALSE(plan.volume);
}

TEST(ScenePlan, HoldsEverySurfaceWhereAllIsSeen) {
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

TEST(ScenePlan, OfAStudyIsEnoughForAnyScene) {
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

TEST(SceneFromJson, RefusesStructuresThatAreNoneByTheirPlace) {
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

TEST(SceneToJson, KeepsWhatARecordOfOneWithoutStructuresHad) {
  EXPECT_EQ(scene_to_json(Scene()).size(), 3U);
  EXPECT_EQ(scene_to_json(of(R"({"structures": ["heart"]})")).at("structures"),
            nlohmann::json::array({"heart"}));
}

}  // namespace
}  // namespace beatlas::build
