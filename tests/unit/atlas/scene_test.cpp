#include "runtime/atlas/scene.h"

#include <gtest/gtest.h>

namespace beatlas::atlas {
namespace {

TEST(Scene, HoldsWhatItsUseNeeds) {
  for (Structure structure : kAllStructures) {
    for (std::string_view kind : kKinds) {
      const bool of_wall = structure == Structure::LvBlood ||
                           structure == Structure::LvMyocardium || structure == Structure::RvBlood;
      const bool of_surface =
          kind == kSurfaceKind || kind == kMotionKind || (kind == kMapKind && of_wall);
      const bool is_there = (kind == kFieldKind && !is_beyond_base(structure)) || of_surface ||
                            (kind == kVolumeKind && structure == Structure::Heart);
      EXPECT_EQ(kind_exists(kind, structure), is_there);
      EXPECT_EQ(scene_holds("full", kind, structure), is_there);
      EXPECT_EQ(scene_holds("anatomy", kind, structure), of_surface);
      EXPECT_EQ(scene_holds("palpation", kind, structure),
                (kind == kFieldKind && structure == Structure::Heart) ||
                    (of_surface && structure == Structure::LvBlood));
      EXPECT_FALSE(scene_holds("nothing", kind, structure));
    }
  }
}

TEST(Scene, IsNamedForWhatIsMissing) {
  EXPECT_EQ(scenes_that_hold(kFieldKind, Structure::Heart), "palpation or full");
  EXPECT_EQ(scenes_that_hold(kFieldKind, Structure::RvBlood), "full");
  EXPECT_EQ(scenes_that_hold(kSurfaceKind, Structure::LvBlood), "palpation, anatomy or full");
  EXPECT_EQ(scenes_that_hold(kSurfaceKind, Structure::RvBlood), "anatomy or full");
  EXPECT_EQ(scenes_that_hold(kMapKind, Structure::LvMyocardium), "anatomy or full");
  EXPECT_EQ(scenes_that_hold(kVolumeKind, Structure::Heart), "full");
}

TEST(ItemPath, TellsKindAndStructureApart) {
  EXPECT_EQ(item_path(kFieldKind, Structure::LvBlood), "fields/lv_blood.field.zst");
  EXPECT_EQ(item_path(kSurfaceKind, Structure::Heart), "surfaces/heart.drc");
  EXPECT_EQ(item_path(kMotionKind, Structure::Heart), "surfaces/heart.motion");
  EXPECT_EQ(item_path(kMapKind, Structure::LvBlood), "maps/lv_blood.map.zst");
  EXPECT_EQ(item_path(kVolumeKind, Structure::Heart), "volumes/heart.volume.zst");
  EXPECT_EQ(item_path(kSurfaceKind, Structure::Heart, 1), "surfaces/heart.level1.drc");
  EXPECT_EQ(item_path(kMotionKind, Structure::Heart, 2), "surfaces/heart.level2.motion");
  EXPECT_EQ(item_path(kMapKind, Structure::LvBlood, 1), "maps/lv_blood.level1.map.zst");
}

}  // namespace
}  // namespace beatlas::atlas
