#include "runtime/atlas/scene.h"

#include <gtest/gtest.h>

namespace beatlas::atlas {
namespace {

TEST(Scene, HoldsWhatItsUseNeeds) {
  for (Structure structure : kAllStructures) {
    for (std::string_view kind : kKinds) {
      EXPECT_TRUE(scene_holds("full", kind, structure));
      EXPECT_EQ(scene_holds("anatomy", kind, structure), kind != kFieldKind);
      EXPECT_EQ(scene_holds("palpation", kind, structure),
                kind == kFieldKind && structure == Structure::Heart);
      EXPECT_FALSE(scene_holds("nothing", kind, structure));
    }
  }
}

TEST(Scene, IsNamedForWhatIsMissing) {
  EXPECT_EQ(scenes_that_hold(kFieldKind, Structure::Heart), "palpation or full");
  EXPECT_EQ(scenes_that_hold(kFieldKind, Structure::RvBlood), "full");
  EXPECT_EQ(scenes_that_hold(kSurfaceKind, Structure::LvBlood), "anatomy or full");
}

TEST(ItemPath, TellsKindAndStructureApart) {
  EXPECT_EQ(item_path(kFieldKind, Structure::LvBlood), "fields/lv_blood.field.zst");
  EXPECT_EQ(item_path(kSurfaceKind, Structure::Heart), "surfaces/heart.drc");
  EXPECT_EQ(item_path(kMotionKind, Structure::Heart), "surfaces/heart.motion.zst");
}

}  // namespace
}  // namespace beatlas::atlas
