#include "pipeline/build/made_package.h"

#include <gtest/gtest.h>

#include "pipeline/study/files.h"
#include "tests/unit/study/temporary_folder.h"

namespace beatlas::build {
namespace {

TEST(MadePackage, IsNotWhatAKillLeftBesideIt) {
  const study::TemporaryFolder folder;
  const std::filesystem::path package = folder.path() / "heart.beatlas";
  study::write_text(package, "package");
  study::write_text(folder.path() / ".partial-1-0-heart.beatlas", "package");
  study::Study study = study::Study::create(folder.path() / "exam.study");
  study::StageRecord record;
  record.package_sha256 = study::sha256_of_file(package);
  study.begin(study::Stage::Pack);
  study.commit(study::Stage::Pack, record, {});
  EXPECT_EQ(made_package(study).filename(), package.filename());
}

}  // namespace
}  // namespace beatlas::build
