#include "pipeline/study/study.h"

#include <algorithm>
#include <memory>

#include <gtest/gtest.h>

#include "pipeline/study/files.h"
#include "pipeline/study/state.h"
#include "runtime/base/error.h"
#include "tests/unit/study/temporary_folder.h"

namespace beatlas::study {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

class StudyTest : public ::testing::Test {
 protected:
  void put(const std::string& name, const std::string& text) {
    make_folder((folder_.path() / name).parent_path());
    write_text(folder_.path() / name, text);
  }
  /// A stage whose files hold their own names.
  void run(Study& study, Stage stage, const std::vector<std::string>& files,
           json options = json::object()) {
    StageRecord record{"1", "a", std::move(options), {}, {}, {}, {}};
    const std::vector<Stage> sources = sources_of(stage);
    if (std::all_of(sources.begin(), sources.end(),
                    [&](Stage source) { return study.find(source) != nullptr; })) {
      record.inputs = study.inputs_now(stage);
    }
    study.begin(stage);
    for (const std::string& file : files) put(file, file);
    study.commit(stage, std::move(record), files);
  }
  const Wanted wanted_{"1", "a", json::object(), std::nullopt};

  std::string refusal() {
    try {
      (void)Study::open(folder_.path());
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  }

  TemporaryFolder folder_;
};

TEST_F(StudyTest, RecordsAreReadBack) {
  {
    Study study = Study::create(folder_.path());
    study.set_recipe({{"field", {{"voxel_mm", 2}}}});
    study.set_seeds(json{{"seeds", json::array()}});
    study.set_refusal(Refusal{Stage::Pack, "too far off"});
    run(study, Stage::Import, {"exam/exam.json"}, {{"phases", 0}});
  }
  const Study again = Study::open(folder_.path());
  const StageRecord* record = again.find(Stage::Import);
  ASSERT_NE(record, nullptr);
  ASSERT_TRUE(again.refusal());
  EXPECT_EQ(again.refusal()->stage, Stage::Pack);
  EXPECT_EQ(again.refusal()->reason, "too far off");
  EXPECT_EQ(record->version, "1");
  EXPECT_EQ(record->options, (json{{"phases", 0}}));
  EXPECT_EQ(record->outputs.at("exam/exam.json"),
            sha256_of_file(folder_.path() / "exam" / "exam.json"));
  EXPECT_EQ(again.recipe()->at("field").at("voxel_mm"), 2);
  EXPECT_TRUE(again.seeds().has_value());
  EXPECT_EQ(again.find(Stage::Segment), nullptr);
}

TEST_F(StudyTest, AnEditIsToldFromWhatTheStageWrote) {
  Study study = Study::create(folder_.path());
  run(study, Stage::Import, {"exam/exam.json"});
  run(study, Stage::Segment, {"segment/segment.json", "segment/labels.nii.gz", kLabelsAsMade});
  EXPECT_TRUE(state_of(study, Stage::Segment, wanted_).up_to_date());
  put("segment/labels.nii.gz", "painted");
  StageState state = state_of(study, Stage::Segment, wanted_);
  EXPECT_EQ(state.edited, std::vector<std::string>{"segment/labels.nii.gz"});
  EXPECT_TRUE(state.up_to_date()) << "an edit is no reason to run again";
  // Without what tells how they were made, no edit can be told.
  fs::remove(folder_.path() / kLabelsAsMade);
  EXPECT_EQ(state_of(study, Stage::Segment, wanted_).missing,
            std::vector<std::string>{kLabelsAsMade});
  put("segment/labels.nii.gz", "segment/labels.nii.gz");
  EXPECT_EQ(state_of(study, Stage::Segment, wanted_).missing,
            std::vector<std::string>{kLabelsAsMade});
}

TEST_F(StudyTest, AStageIsStaleForInputsOptionsVersionAndMissingFiles) {
  Study study = Study::create(folder_.path());
  run(study, Stage::Import, {"exam/exam.json"});
  run(study, Stage::Segment, {"segment/segment.json"});
  EXPECT_EQ(state_of(study, Stage::Segment, {"2", "b", json::object(), std::nullopt}).changed,
            std::vector<std::string>{"the program's version"});
  EXPECT_EQ(state_of(study, Stage::Segment, {"1", "b", json::object(), std::nullopt}).changed,
            std::vector<std::string>{"the program"});
  // Without images to read anew an import stands.
  Wanted another_build = wanted_;
  another_build.sources_sha256 = "b";
  EXPECT_TRUE(state_of(study, Stage::Import, another_build).up_to_date());
  another_build.source_files = "abc";
  EXPECT_EQ(state_of(study, Stage::Import, another_build).changed.front(), "the program");
  EXPECT_EQ(state_of(study, Stage::Segment, {"1", "a", {{"edge", 1}}, std::nullopt}).changed,
            std::vector<std::string>{"its options"});
  Wanted other_source = wanted_;
  other_source.source_files = "abc";
  EXPECT_EQ(state_of(study, Stage::Import, other_source).changed,
            std::vector<std::string>{"the source"});
  // As it is after a stop while the import is made anew.
  {
    study.begin(Stage::Import);
    EXPECT_EQ(state_of(study, Stage::Segment, wanted_).changed,
              std::vector<std::string>{"the stage import"});
    run(study, Stage::Import, {"exam/exam.json"});
  }
  put("exam/exam.json", "changed");
  EXPECT_EQ(state_of(study, Stage::Segment, wanted_).changed,
            std::vector<std::string>{"exam/exam.json"});
  put("exam/exam.json", "exam/exam.json");
  EXPECT_TRUE(state_of(study, Stage::Segment, wanted_).up_to_date());
  fs::remove(folder_.path() / "segment" / "segment.json");
  EXPECT_FALSE(state_of(study, Stage::Segment, wanted_).up_to_date());
}

TEST_F(StudyTest, AStageThatRunsAgainAndMakesTheSameLeavesLaterOnesAlone) {
  Study study = Study::create(folder_.path());
  run(study, Stage::Import, {"exam/exam.json"});
  run(study, Stage::Segment, {"segment/segment.json"});
  run(study, Stage::Import, {"exam/exam.json"});
  EXPECT_TRUE(state_of(study, Stage::Segment, wanted_).up_to_date());
}

TEST_F(StudyTest, WhatWasHalfWrittenIsNoEdit) {
  {
    Study study = Study::create(folder_.path());
    run(study, Stage::Import, {"exam/exam.json", "exam/view_00.nii.gz"});
    study.begin(Stage::Import);
    put("exam/exam.json", "half");  // and the program is killed
  }
  Study study = Study::create(folder_.path());
  EXPECT_EQ(study.interrupted(), Stage::Import);
  EXPECT_FALSE(state_of(study, Stage::Import, wanted_).ran);
  run(study, Stage::Import, {"exam/exam.json"});
  EXPECT_FALSE(study.interrupted());
  EXPECT_FALSE(fs::exists(folder_.path() / "exam" / "view_00.nii.gz"))
      << "files of the run before are removed though a kill lay between";
  EXPECT_TRUE(state_of(Study::open(folder_.path()), Stage::Import, wanted_).up_to_date());
}

TEST_F(StudyTest, PartialFilesOfAKilledProgramAreCleared) {
  put("mesh/.partial-heart_000.ply", "half");
  put(".partial-study.json", "half");
  fs::remove_all(folder_.path() / "mesh");
  { const Study study = Study::create(folder_.path()); }
  put("study.json", R"({"study_format": 2, "stages": {}})");
  put("mesh/.partial-heart_000.ply", "half");
  const Study study = Study::create(folder_.path());
  EXPECT_FALSE(fs::exists(folder_.path() / "mesh" / ".partial-heart_000.ply"));
  EXPECT_FALSE(fs::exists(folder_.path() / ".partial-study.json"));
}

TEST_F(StudyTest, WhatWasDrawnOnAPictureIsPutAside) {
  Study study = Study::create(folder_.path());
  run(study, Stage::Pictures, {"pictures/overlay.png"});
  put("pictures/overlay.png", "with notes");
  EXPECT_EQ(edited_for_the_eye(study, Stage::Pictures),
            std::vector<std::string>{"pictures/overlay.png"});
  EXPECT_TRUE(edited_outputs(study, Stage::Pictures).empty());
  run(study, Stage::Pictures, {"pictures/overlay.png"});
  const auto kept = read_bytes(folder_.path() / "pictures" / "overlay.png.edited");
  EXPECT_EQ(kept.size(), std::string("with notes").size());
}

TEST_F(StudyTest, OneProgramAtATimeWrites) {
  auto first = std::make_unique<Study>(Study::create(folder_.path()));
  EXPECT_TRUE(Lock::held(folder_.path()));
  int told = 0;
  std::atomic<bool> cancel{true};
  EXPECT_THROW((void)Study::create(folder_.path(), {[&] { ++told; }, &cancel}), Error);
  EXPECT_EQ(told, 1);
  first.reset();
  EXPECT_FALSE(Lock::held(folder_.path()));
  EXPECT_NO_THROW((void)Study::create(folder_.path(), {[&] { ++told; }, &cancel}));
  EXPECT_EQ(told, 1);
}

TEST_F(StudyTest, PackReadsSurfacesAndTheirMaps) {
  Study study = Study::create(folder_.path());
  for (const Stage stage : {Stage::Import, Stage::Segment, Stage::Register, Stage::Field}) {
    run(study, stage, {std::string(stage_name(stage)) + "/a.json"});
  }
  EXPECT_THROW((void)study.inputs_now(Stage::Pack), Error);
  const std::string map = "mesh/map_lv_blood.csv";
  run(study, Stage::Mesh, {"mesh/mesh.json", map});
  EXPECT_EQ(study.inputs_now(Stage::Pack).size(), 6U);
  run(study, Stage::Pack, {"pack/contents.json"});
  put(map, "a segment painted over");
  EXPECT_EQ(edited_outputs(study, Stage::Mesh), std::vector<std::string>{map});
  EXPECT_EQ(state_of(study, Stage::Pack, wanted_).changed, std::vector<std::string>{map});
}

TEST_F(StudyTest, AFolderWithOtherFilesIsNotTaken) {
  put("thesis.txt", "do not touch");
  EXPECT_THROW((void)Study::create(folder_.path()), Error);
}

TEST_F(StudyTest, IsTakenAgainWhereItsFirstBuildFailed) {
  {
    const Study study = Study::create(folder_.path());
    put("given/labels.nii.gz", "labels");
  }
  EXPECT_TRUE(Study::open(folder_.path()).find(Stage::Import) == nullptr);
  EXPECT_NO_THROW((void)Study::create(folder_.path()));
}

TEST_F(StudyTest, AMissingStageIsNamedWithItsCommand) {
  const Study study = Study::create(folder_.path());
  try {
    (void)study.inputs_now(Stage::Field);
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
    EXPECT_NE(std::string(error.what()).find("beatlas register --study"), std::string::npos);
  }
}

TEST_F(StudyTest, ADamagedIndexIsRefusedByItsPlace) {
  EXPECT_NE(refusal().find("no study"), std::string::npos);
  put("study.json", R"({"study_format": 2, "stages": {}, "more": 1})");
  EXPECT_NE(refusal().find("/more"), std::string::npos);
  put("study.json", R"({"study_format": 3, "stages": {}})");
  EXPECT_NE(refusal().find("/study_format"), std::string::npos);
  put("study.json", R"({"study_format": 2, "stages": {"import": {"version": "1", "options": {},
      "inputs": {}, "outputs": {"../../precious": "00"}}}})");
  EXPECT_NE(refusal().find("leads out"), std::string::npos);
}

TEST_F(StudyTest, WithLinksIsRefusedAndNothingOutsideIsTouched) {
  const TemporaryFolder victim;
  write_text(victim.path() / "keep.txt", "precious");
  write_json(folder_.path() / "study.json",
             {{"study_format", 2}, {"former", {"segment/keep.txt"}}, {"stages", json::object()}});
  fs::create_directory_symlink(victim.path(), folder_.path() / "segment");
  EXPECT_NE(refusal().find("segment is a link"), std::string::npos) << refusal();
  EXPECT_THROW((void)Study::create(folder_.path()), Error);
  fs::remove(folder_.path() / "segment");
  make_folder(folder_.path() / "exam");
  fs::create_symlink(victim.path() / "keep.txt", folder_.path() / "exam" / "exam.json");
  EXPECT_NE(refusal().find("exam.json is a link"), std::string::npos) << refusal();
  EXPECT_TRUE(fs::exists(victim.path() / "keep.txt"));
  fs::remove(folder_.path() / "exam" / "exam.json");
  EXPECT_EQ(refusal(), "");
}

TEST_F(StudyTest, MayBeReachedByALink) {
  const TemporaryFolder elsewhere;
  Study::create(folder_.path()).save();
  fs::create_directory_symlink(folder_.path(), elsewhere.path() / "exam.study");
  EXPECT_NO_THROW((void)Study::open(elsewhere.path() / "exam.study"));
}

}  // namespace
}  // namespace beatlas::study
