#include "pipeline/study/given_files.h"

#include <fstream>

#include <gtest/gtest.h>

#include "pipeline/study/files.h"
#include "runtime/base/error.h"
#include "runtime/base/json_text.h"
#include "tests/unit/study/temporary_folder.h"

namespace beatlas::study::given_files_tests {
namespace {
namespace fs = std::filesystem;

/// On an oblique grid whose numbers are no floats.
GivenLabels given(std::uint8_t label) {
  GivenLabels out;
  Grid& grid = out.images.grid;
  grid.size = {7, 5, 3};
  grid.mm_from_index.linear() =
      (Eigen::AngleAxisd(0.3, Vec3(1, 2, 3).normalized()).toRotationMatrix() *
       Vec3(1.1, 1.3, 7.7).asDiagonal());
  grid.mm_from_index.translation() = Vec3(-100.0 / 3, 1e-3 / 7, 250.1);
  out.images.phases.assign(2, std::vector<std::uint8_t>(grid.count(), 255));
  out.images.phases[1][9] = label;
  out.phases = {0, 7};
  out.file_sha256 = std::string(64, 'a');
  out.sha256 = given_sha256(out.images, out.phases);
  return out;
}

std::size_t files_in(const fs::path& folder) {
  std::size_t count = 0;
  for (const auto& entry : fs::directory_iterator(folder)) count += entry.is_regular_file() ? 1 : 0;
  return count;
}

std::string refusal(const fs::path& study, const nlohmann::json& json) {
  try {
    (void)read_given(study, json, "/given/labels");
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
    return error.what();
  }
  ADD_FAILURE() << "was read";
  return {};
}

TEST(GivenLabels, ComeBackBitByBit) {
  const TemporaryFolder study;
  const GivenLabels before = given(3);
  const nlohmann::json told = parse_json(json_text(write_given(study.path(), before)));
  const GivenLabels after = read_given(study.path(), told, "/given/labels");
  EXPECT_TRUE(after.images.grid == before.images.grid);
  EXPECT_EQ(after.images.phases, before.images.phases);
  EXPECT_EQ(after.phases, before.phases);
  EXPECT_EQ(after.file_sha256, before.file_sha256);
  EXPECT_EQ(after.sha256, before.sha256);
}

TEST(GivenLabels, HaveAHashOfWhatTheySay) {
  const GivenLabels first = given(3);
  EXPECT_NE(first.sha256, given(2).sha256);
  EXPECT_NE(first.sha256, given_sha256(first.images, {0, 6}));
  GivenLabels moved = given(3);
  moved.images.grid.mm_from_index.translation()[0] += 1e-9;
  EXPECT_NE(first.sha256, given_sha256(moved.images, moved.phases));
}

TEST(GivenLabels, ThatAreGoneOrWereChangedAreAskedForAgain) {
  const TemporaryFolder study;
  const nlohmann::json told = write_given(study.path(), given(3));
  const nlohmann::json other = write_given(study.path(), given(2));
  ASSERT_EQ(files_in(study.path() / "given"), 2U);
  // The one's file under the other's name.
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(study.path() / "given")) {
    files.push_back(entry.path());
  }
  fs::copy_file(files[0], files[1], fs::copy_options::overwrite_existing);
  const bool first =
      files[1].filename().string().starts_with(told.at("sha256").get<std::string>().substr(0, 16));
  const nlohmann::json& spoiled = first ? told : other;
  EXPECT_NE(refusal(study.path(), spoiled).find("again"), std::string::npos);
  (void)read_given(study.path(), first ? other : told, "/given/labels");
  fs::remove(files[1]);
  EXPECT_NE(refusal(study.path(), spoiled).find("gone"), std::string::npos);
  nlohmann::json hostile = told;
  hostile["sha256"] = "../../../etc/passwd";
  EXPECT_NE(refusal(study.path(), hostile).find("/given/labels/sha256"), std::string::npos);
}

TEST(GivenLabels, ThatNothingTellsOfAreClearedAway) {
  const TemporaryFolder study;
  const nlohmann::json one = write_given(study.path(), given(3));
  const nlohmann::json two = write_given(study.path(), given(2));
  (void)write_given(study.path(), given(1));
  write_text(study.path() / "given" / "notes.txt", "not ours");
  clear_given(study.path(), {{{"labels", one}}, {{"painted", two}}});
  EXPECT_EQ(files_in(study.path() / "given"), 3U);
  (void)read_given(study.path(), one, "/given/labels");
  (void)read_given(study.path(), two, "/given/painted");
  clear_given(study.path(), {nlohmann::json::object()});
  EXPECT_EQ(files_in(study.path() / "given"), 1U) << "and what is not ours stays";
  clear_given(study.path() / "nowhere", {});
}

}  // namespace
}  // namespace beatlas::study::given_files_tests
