#include "runtime/base/replace_file.h"

#include <fstream>
#include <iterator>
#include <span>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "runtime/base/error.h"
#include "tests/unit/study/temporary_folder.h"

namespace beatlas {
namespace {
namespace fs = std::filesystem;
using study::TemporaryFolder;

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::size_t count_files(const fs::path& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), {}));
}

void fill(const fs::path& file, const std::string& text) { std::ofstream(file) << text; }

TEST(ReplaceFile, GivesTheNameTheNewContentAndLeavesNothingElse) {
  const TemporaryFolder folder;
  replace_file(folder.path() / "a", "old");
  replace_file(folder.path() / "a", "new");
  EXPECT_EQ(text_of(folder.path() / "a"), "new");
  EXPECT_EQ(count_files(folder.path()), 1U);
}

TEST(ReplaceFile, LeavesTheOldFileAndNothingElseWhenWritingFails) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "a.txt";
  replace_file(file, "old");
  const auto broken_off = [](const fs::path& temporary) {
    fill(temporary, "half");
    throw_invalid("broken off");
  };
  EXPECT_THROW(replace_file(file, broken_off), Error);
  EXPECT_EQ(text_of(file), "old");
  EXPECT_EQ(count_files(folder.path()), 1U);
}

TEST(ReplaceFile, LeavesTheOldFileAndNothingElseWhereTheNewOneIsRefused) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "a.txt";
  const std::string text = "new";
  const auto bytes = std::as_bytes(std::span(text));
  replace_file(file, "old");
  const auto refuse = [&](const fs::path& temporary) {
    EXPECT_EQ(text_of(temporary), "new");
    throw Error(ErrorCode::Machine, "stopped");
  };
  try {
    replace_file(file, bytes, refuse);
    FAIL() << "was written";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "stopped");
  }
  EXPECT_EQ(text_of(file), "old");
  EXPECT_EQ(count_files(folder.path()), 1U);
  replace_file(file, bytes, [&](const fs::path&) { EXPECT_EQ(text_of(file), "old"); });
  EXPECT_EQ(text_of(file), "new");
}

TEST(RefuseOtherKind, LetsOnlyWhatBeginsAlikeBeReplaced) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "a";
  const auto refused = [&](const std::string& there, const std::string& text) {
    fill(file, there);
    try {
      refuse_other_kind(file, text);
      return false;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::Usage);
      EXPECT_EQ(text_of(file), there);
      return true;
    }
  };
  EXPECT_FALSE(refused("t,x\n1,2\n", "t,x\n3,4\n"));
  EXPECT_FALSE(refused("", "t,x\n"));
  EXPECT_TRUE(refused("t,x,y\n1,2,3\n", "t,x\n3,4\n"));
  EXPECT_TRUE(refused("t\n1\n", "t,x\n3,4\n"));
  EXPECT_TRUE(refused("PK\x03\x04", "t,x\n"));
  EXPECT_FALSE(refused("<svg width='1'>", "<svg width='2'>"));
  EXPECT_TRUE(refused("<html>", "<svg>"));
  EXPECT_FALSE(refused("t,x\r\n1,2\r\n", "t,x\n3,4\n"));
  EXPECT_FALSE(refused(R"({"muscle":{},"version":1,"more":2})", R"({"version": 1, "muscle": {}})"));
  EXPECT_TRUE(refused("{\n  \"version\": 1\n}", "{\n  \"muscle\": {}\n}"));
  fs::remove(file);
  EXPECT_NO_THROW(refuse_other_kind(file, "t,x\n"));
  EXPECT_NO_THROW(refuse_other_kind(folder.path(), "t,x\n"));  // whoever writes it says what it is
}

TEST(ReplaceFile, KeepsTheEndingOfTheName) {
  const TemporaryFolder folder;
  for (const std::string& name : {std::string("x.nii.gz"), std::string(240, 'x') + ".nii.gz"}) {
    std::string temporary;
    replace_file(folder.path() / name, [&](const fs::path& part) {
      temporary = part.filename().string();
      EXPECT_TRUE(is_partial(part));
      fill(part, "1");
    });
    EXPECT_TRUE(temporary.ends_with(".nii.gz")) << temporary;
    EXPECT_EQ(text_of(folder.path() / name), "1");
  }
}

TEST(ReplaceFile, WritesThroughNoLinkThatLiesInItsWay) {
  const TemporaryFolder folder;
  const fs::path victim = folder.path() / "victim";
  fill(victim, "untouched");
  // Whatever name the temporary would have, it is taken by a link: so say the names of a first run.
  fs::path first;
  const auto note = [&](const fs::path& part) {
    first = part;
    fill(part, "1");
  };
  replace_file(folder.path() / "a", note);
  fs::create_symlink(victim, first);
  fs::create_symlink(victim, folder.path() / ".partial-a");
  fs::path second;
  replace_file(folder.path() / "a", [&](const fs::path& part) {
    second = part;
    fill(part, "2");
  });
  EXPECT_NE(second, first);
  EXPECT_EQ(text_of(folder.path() / "a"), "2");
  EXPECT_EQ(text_of(victim), "untouched");
  EXPECT_TRUE(can_replace(folder.path() / "a"));
  EXPECT_EQ(text_of(victim), "untouched");
}

TEST(ReplaceFile, ReplacesALinkAndNotWhatItLeadsTo) {
  const TemporaryFolder folder;
  fill(folder.path() / "victim", "untouched");
  fs::create_symlink(folder.path() / "victim", folder.path() / "a");
  replace_file(folder.path() / "a", "new");
  EXPECT_EQ(text_of(folder.path() / "victim"), "untouched");
  EXPECT_FALSE(fs::is_symlink(folder.path() / "a"));
}

TEST(ReplaceFile, LetsSeveralWritersOfOneFileWorkAtATime) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "a";
  replace_file(file, [&](const fs::path& outer) {
    fill(outer, "outer");
    replace_file(file, "inner");
    EXPECT_EQ(text_of(outer), "outer");
  });
  EXPECT_EQ(text_of(file), "outer");
}

TEST(ReplaceFile, NamesTheFileWhereThereIsNoFolder) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "none" / "a";
  EXPECT_FALSE(can_replace(file));
  try {
    replace_file(file, "new");
    FAIL() << "was written";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::Machine);
    EXPECT_TRUE(std::string(error.what()).starts_with(file.string() + " cannot be written"));
  }
}

}  // namespace
}  // namespace beatlas
