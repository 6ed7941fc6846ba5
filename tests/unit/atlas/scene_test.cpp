#include "runtime/atlas/scene.h"

#include <gtest/gtest.h>

namespace beatlas::atlas {
namespace {

TEST(Scene, HoldsWhatItsUseNeeds) {
  for (Structure structure : kAllStructures) {
    for (std::string_view kind : kKinds) {
      const bool is_there = kind != kVolumeKind || structure == Structure::Heart;
      EXPECT_EQ(scene_holds("full", kind, structure), is_there);
      EXPECT_EQ(scene_holds("anatomy", kind, structure),
                kind == kSurfaceKind || kind == kMotionKind);
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
  EXPECT_EQ(scenes_that_hold(kVolumeKind, Structure::Heart), "full");
}

TEST(ItemPath, TellsKindAndStructureApart) {
  EXPECT_EQ(item_path(kFieldKind, Structure::LvBlood), "fields/lv_blood.field.zst");
  EXPECT_EQ(item_path(kSurfaceKind, Structure::Heart), "surfaces/heart.drc");
  EXPECT_EQ(item_path(kMotionKind, Structure::Heart), "surfaces/heart.motion");
  EXPECT_EQ(item_path(kVolumeKind, Structure::Heart), "volumes/heart.volume.zst");
}

}  // namespace
}  // namespace beatlas::atlas
