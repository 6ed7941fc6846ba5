#include "pipeline/build/study_status.h"

#include <gtest/gtest.h>

namespace beatlas::build {
namespace {

StageStatus refused_pack() {
  StageStatus out;
  out.stage = study::Stage::Pack;
  out.state = "refused";
  out.refused = "too much volume; no package was written";
  return out;
}

TEST(StudyStatus, CountsFilesOfAFolderWhereThereAreMany) {
  StudyStatus status;
  status.stages.push_back(refused_pack());
  std::vector<std::string>& changed = status.stages.back().changed;
  changed = {"its options", "field/heart.vdb"};
  for (int n = 0; n < 70; ++n) changed.push_back("mesh/heart_" + std::to_string(n) + ".ply");
  changed.insert(changed.end(), {"segment/labels.nii.gz", "segment/long_axis.json"});
  EXPECT_EQ(to_text(status),
            "pack      refused: too much volume; no package was written; its options, "
            "field/heart.vdb, 70 files of mesh/, segment/labels.nii.gz, segment/long_axis.json "
            "changed since the last package\n");
  // For programs, each by its name.
  EXPECT_EQ(to_json(status)["stages"][0]["changed"].size(), changed.size());
}

TEST(StudyStatus, PartsWhatItTellsOfAStage) {
  StudyStatus status;
  StageStatus stage;
  stage.stage = study::Stage::Segment;
  stage.state = "stale";
  stage.missing = {"segment/a", "segment/b", "segment/c", "segment/d"};
  stage.changed = {"its options"};
  stage.unused_edits = {"segment/labels_source.nii.gz"};
  status.stages.push_back(stage);
  EXPECT_EQ(to_text(status),
            "segment   stale: 4 files of segment/ gone; its options changed; "
            "segment/labels_source.nii.gz changed by hand, but nothing is made from it\n");
}

}  // namespace
}  // namespace beatlas::build
