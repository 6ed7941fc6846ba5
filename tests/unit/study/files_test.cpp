#include "pipeline/study/files.h"

#include <fstream>
#include <iterator>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "tests/unit/study/temporary_folder.h"

namespace beatlas::study {
namespace {
namespace fs = std::filesystem;

std::size_t count_files(const fs::path& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), {}));
}

ErrorCode code_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.code();
  }
  return ErrorCode{0};
}

TEST(CheckWritable, TellsAMissingFolderAndAFolderInPlaceOfTheFile) {
  const TemporaryFolder folder;
  EXPECT_EQ(code_of([&] { check_writable(folder.path() / "none" / "a"); }), ErrorCode::Machine);
  EXPECT_EQ(code_of([&] { check_writable(folder.path()); }), ErrorCode::Machine);
  EXPECT_NO_THROW(check_writable(folder.path() / "a"));
  EXPECT_EQ(count_files(folder.path()), 0U);
}

TEST(ReadJson, RefusesBrokenTextAndKeysGivenTwice) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "a.json";
  for (const char* text : {"{\"a\": 1", "", "{\"a\": 1, \"a\": 2}", "[{\"b\":{\"c\":1,\"c\":1}}]",
                           "{\"a\": 1e999}", "{\"a\": NaN}"}) {
    write_text(file, text);
    EXPECT_EQ(code_of([&] { (void)read_json(file); }), ErrorCode::InvalidInput) << text;
  }
  write_text(file, "{\"a\": {\"b\": 1}, \"b\": {\"a\": 2}}");
  EXPECT_NO_THROW((void)read_json(file));
  EXPECT_EQ(code_of([&] { (void)read_json(folder.path() / "none.json"); }),
            ErrorCode::InvalidInput);
}

TEST(WriteJson, NumbersReadBackTheSame) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "a.json";
  const std::vector<double> numbers{0.1, 1.0 / 3.0, 1e-300, -123456.789012345, 5e-324};
  write_json(file, numbers);
  EXPECT_EQ(read_json(file).get<std::vector<double>>(), numbers);
}

}  // namespace
}  // namespace beatlas::study
