#include "pipeline/study/study.h"

#include <gtest/gtest.h>

#include "pipeline/study/files.h"
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

TEST_F(StudyTest, records_are_read_back) {
  Study study = Study::create(folder_.path());
  study.set_recipe({{"field", {{"voxel_mm", 2}}}});
  put("exam/exam.json", "{}");
  study.commit(Stage::Import, "1.2", {{"phases", 0}}, {"exam/exam.json"}, "abc");
  const Study again = Study::open(folder_.path());
  const StageRecord& record = again.record(Stage::Import);
  EXPECT_EQ(record.version, "1.2");
  EXPECT_EQ(record.options, (json{{"phases", 0}}));
  EXPECT_EQ(record.inputs.at("source"), "abc");
  EXPECT_EQ(record.outputs.at("exam/exam.json"),
            sha256_of_file(folder_.path() / "exam" / "exam.json"));
  EXPECT_EQ(again.recipe()->at("field").at("voxel_mm"), 2);
}

TEST_F(StudyTest, a_stage_records_the_hashes_of_what_it_read) {
  Study study = Study::create(folder_.path());
  put("exam/exam.json", "{}");
  study.commit(Stage::Import, "1", json::object(), {"exam/exam.json"});
  put("exam/exam.json", "{\"edited\": true}");
  EXPECT_EQ(study.edited_outputs(Stage::Import), std::vector<std::string>{"exam/exam.json"});
  put("segment/segment.json", "{}");
  study.commit(Stage::Segment, "1", json::object(), {"segment/segment.json"});
  EXPECT_EQ(study.record(Stage::Segment).inputs.at("exam/exam.json"),
            sha256_of_file(folder_.path() / "exam" / "exam.json"));
}

TEST_F(StudyTest, running_a_stage_again_makes_later_ones_stale) {
  Study study = Study::create(folder_.path());
  put("exam/exam.json", "{}");
  put("segment/segment.json", "{}");
  study.commit(Stage::Import, "1", json::object(), {"exam/exam.json"});
  study.commit(Stage::Segment, "1", json::object(), {"segment/segment.json"});
  study.commit(Stage::Import, "1", json::object(), {"exam/exam.json"});
  EXPECT_FALSE(study.has(Stage::Segment));
  EXPECT_THROW((void)Study::open(folder_.path()).record(Stage::Segment), Error);
  study.commit(Stage::Segment, "1", json::object(), {"segment/segment.json"});
  EXPECT_TRUE(study.has(Stage::Segment));
}

TEST_F(StudyTest, files_that_a_new_run_no_longer_has_are_removed) {
  Study study = Study::create(folder_.path());
  put("exam/exam.json", "{}");
  put("exam/view_00.nii.gz", "x");
  study.commit(Stage::Import, "1", json::object(), {"exam/exam.json", "exam/view_00.nii.gz"});
  study.commit(Stage::Import, "1", json::object(), {"exam/exam.json"});
  EXPECT_FALSE(fs::exists(folder_.path() / "exam" / "view_00.nii.gz"));
  EXPECT_TRUE(fs::exists(folder_.path() / "exam" / "exam.json"));
}

TEST_F(StudyTest, a_folder_with_other_files_is_not_taken) {
  put("thesis.txt", "do not touch");
  EXPECT_THROW((void)Study::create(folder_.path()), Error);
}

TEST_F(StudyTest, a_missing_stage_is_named_with_its_command) {
  const Study study = Study::create(folder_.path());
  try {
    (void)study.record(Stage::Register);
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
    EXPECT_NE(std::string(error.what()).find("beatlas register --study"), std::string::npos);
  }
}

TEST_F(StudyTest, a_damaged_index_is_refused_by_its_place) {
  EXPECT_NE(refusal().find("no study"), std::string::npos);
  put("study.json", R"({"study_format": 1, "stages": {}, "more": 1})");
  EXPECT_NE(refusal().find("/more"), std::string::npos);
  put("study.json", R"({"study_format": 2, "stages": {}})");
  EXPECT_NE(refusal().find("/study_format"), std::string::npos);
  put("study.json", R"({"study_format": 1, "stages": {"import": {"version": "1", "options": {},
      "inputs": {}, "outputs": {"../../precious": "00"}}}})");
  EXPECT_NE(refusal().find("leads out"), std::string::npos);
}

}  // namespace
}  // namespace beatlas::study
