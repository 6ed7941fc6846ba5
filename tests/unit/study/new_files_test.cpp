#include "pipeline/study/new_files.h"

#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "pipeline/study/files.h"
#include "tests/unit/study/temporary_folder.h"

namespace beatlas::study {
namespace {

namespace fs = std::filesystem;

class NewFilesTest : public ::testing::Test {
 protected:
  [[nodiscard]] std::string content(const std::string& name) const {
    std::ifstream in(folder_.path() / name);
    std::ostringstream out;
    out << in.rdbuf();
    return out.str();
  }
  [[nodiscard]] std::size_t count() const {
    std::size_t out = 0;
    for ([[maybe_unused]] const auto& each : fs::directory_iterator(folder_.path())) ++out;
    return out;
  }
  TemporaryFolder folder_;
};

TEST_F(NewFilesTest, ComeTogetherAndBesideOthers) {
  write_text(folder_.path() / "other", "other");
  {
    NewFiles files(folder_.path());
    EXPECT_TRUE(is_partial(files.place()));
    write_text(files.place() / "a", "a");
    EXPECT_FALSE(fs::exists(folder_.path() / "a"));
    write_text(files.place() / "b", "b");
    files.put();
  }
  EXPECT_EQ(content("a"), "a");
  EXPECT_EQ(content("b"), "b");
  EXPECT_EQ(content("other"), "other");
  EXPECT_EQ(count(), 3U);
}

TEST_F(NewFilesTest, TakeNobodysPlace) {
  write_text(folder_.path() / "b", "painted");
  write_text(folder_.path() / "c", "c");
  try {
    NewFiles files(folder_.path());
    for (const char* name : {"a", "b", "c"}) write_text(files.place() / name, name);
    files.put();
    FAIL() << "b was replaced";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::Usage);
    EXPECT_NE(std::string(error.what()).find("b is there and would be lost"), std::string::npos);
  }
  EXPECT_EQ(content("b"), "painted");
  EXPECT_EQ(count(), 2U);  // a did not come alone, and nothing hidden is left

  // The same bytes are no loss; a link is, wherever it leads.
  fs::remove(folder_.path() / "b");
  {
    NewFiles files(folder_.path());
    write_text(files.place() / "c", "c");
    files.put();
  }
  fs::create_symlink("c", folder_.path() / "e");
  {
    NewFiles files(folder_.path());
    write_text(files.place() / "e", "c");
    EXPECT_THROW(files.put(), Error);
  }
  EXPECT_TRUE(fs::is_symlink(folder_.path() / "e"));
  fs::create_symlink("nowhere", folder_.path() / "d");
  NewFiles files(folder_.path());
  write_text(files.place() / "d", "d");
  EXPECT_THROW(files.put(), Error);
  EXPECT_FALSE(fs::exists(folder_.path() / "nowhere"));
}

TEST_F(NewFilesTest, LeaveNoFolderThatWasMadeForThemInVain) {
  const fs::path within = folder_.path() / "out";
  {
    const NewFiles files(within);
    write_text(files.place() / "a", "a");
  }
  EXPECT_FALSE(fs::exists(within));
  fs::create_directory(within);
  { const NewFiles files(within); }
  EXPECT_TRUE(fs::exists(within));
}

}  // namespace
}  // namespace beatlas::study
