#include "runtime/base/within.h"

#include <fstream>

#include <gtest/gtest.h>

#include "tests/unit/study/temporary_folder.h"

namespace beatlas {
namespace {
namespace fs = std::filesystem;

class LiesWithin : public ::testing::Test {
 protected:
  LiesWithin() {
    fs::create_directories(root_ / "exam" / "raw");
    fs::create_directories(root_ / "exam2");
    for (const char* file : {"exam/a.raw", "exam/raw/b.raw", "exam2/c.raw", "d.raw"}) {
      std::ofstream(root_ / file) << "x";
    }
  }

  const study::TemporaryFolder folder_;
  const fs::path& root_ = folder_.path();
};

TEST_F(LiesWithin, WhatIsBesideOrBelow) {
  EXPECT_TRUE(lies_within(root_ / "exam/a.raw", root_ / "exam"));
  EXPECT_TRUE(lies_within(root_ / "exam/raw/b.raw", root_ / "exam/"));
  EXPECT_TRUE(lies_within(root_ / "exam/raw/../a.raw", root_ / "exam"));
  EXPECT_FALSE(lies_within(root_ / "exam/../d.raw", root_ / "exam"));
  EXPECT_FALSE(lies_within(root_ / "exam/../exam2/c.raw", root_ / "exam"));
  EXPECT_FALSE(lies_within(root_ / "exam/none.raw", root_ / "exam"));
}

TEST_F(LiesWithin, NotWhatALinkLeadsOutTo) {
  fs::create_symlink(root_ / "d.raw", root_ / "exam/link.raw");
  fs::create_directory_symlink(root_ / "exam2", root_ / "exam/linked");
  EXPECT_FALSE(lies_within(root_ / "exam/link.raw", root_ / "exam"));
  EXPECT_FALSE(lies_within(root_ / "exam/linked/c.raw", root_ / "exam"));
  fs::create_directory_symlink(root_ / "exam", root_ / "other_name");
  EXPECT_TRUE(lies_within(root_ / "other_name/a.raw", root_ / "other_name"));
}

}  // namespace
}  // namespace beatlas
