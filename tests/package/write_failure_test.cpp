#include <csignal>
#include <fstream>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "runtime/base/error.h"
#include "tests/package/sample_package.h"

namespace beatlas {
namespace {

ErrorCode code_of_writing(const std::filesystem::path& file) {
  try {
    pack::write_package(file, test::tiny_content());
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find(file.string()), std::string::npos);
    return error.code();
  }
  ADD_FAILURE() << "no error";
  return ErrorCode::Usage;
}

TEST(PackageWriter, LeavesTheOldPackageAloneWhenTheDiskFillsUp) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "a.beatlas";
  const atlas::Bytes old(100, std::byte{42});
  test::write_file(file, old);
  // A limit on file size stands in for a full disk: write() fails half-way, as it does there.
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit tight{5000, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &tight), 0);
  const ErrorCode code = code_of_writing(file);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  (void)std::signal(SIGXFSZ, handler);
  EXPECT_EQ(code, ErrorCode::Machine);
  EXPECT_EQ(test::read_file(file), old);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

TEST(PackageWriter, SaysWhereItCannotWrite) {
  const test::TemporaryFolder folder;
  test::write_file(folder.path() / "plain", {});
  EXPECT_EQ(code_of_writing(folder.path() / "plain" / "a.beatlas"), ErrorCode::Machine);
  EXPECT_EQ(code_of_writing(folder.path() / "missing" / "a.beatlas"), ErrorCode::Machine);
  std::filesystem::create_directory(folder.path() / "taken.beatlas");
  EXPECT_EQ(code_of_writing(folder.path() / "taken.beatlas"), ErrorCode::Machine);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 2);
}

TEST(PackageWriter, ReplacesAnOlderPackageAndWritesInTheCurrentFolder) {
  const test::TemporaryFolder folder;
  const auto start = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  test::write_file("a.beatlas", atlas::Bytes(100, std::byte{42}));
  EXPECT_NO_THROW(pack::write_package("a.beatlas", test::tiny_content()));
  EXPECT_GT(std::filesystem::file_size("a.beatlas"), 1000U);
  std::filesystem::current_path(start);
}

}  // namespace
}  // namespace beatlas
