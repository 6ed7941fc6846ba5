// The end of a DICOM file, byte by byte.
#include "pipeline/ingest/dicom_end.h"

#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/study/temporary_folder.h"

namespace beatlas::ingest {
namespace {

using namespace std::string_literals;

constexpr std::int64_t kPixels = 4;  // behind their length
constexpr double kNeeded = 8;
const std::string kEightPixels = "\x08\0\0\0pixelsab"s;
const std::string kShort = "\xE1\x7F\x10\0LO\x04\0word"s;
const std::string kLong = "\xFC\xFF\xFC\xFFOB\0\0\x06\0\0\0\0\0\0\0\0\0"s;

bool whole(const std::string& content, const DicomEncoding& encoding = {}) {
  const study::TemporaryFolder folder;
  const auto file = folder.path() / "image";
  std::ofstream(file, std::ios::binary) << content;
  return goes_on_to_its_end(file, kPixels, kNeeded, encoding);
}

/// Whole if it is cut at the end of an element and nowhere else.
void expect_ends(const std::string& content, const std::vector<std::size_t>& ends,
                 const DicomEncoding& encoding = {}) {
  for (std::size_t size = kEightPixels.size(); size <= content.size(); ++size) {
    const bool end = std::find(ends.begin(), ends.end(), size) != ends.end();
    EXPECT_EQ(whole(content.substr(0, size), encoding), end) << size;
  }
}

TEST(DicomEnd, LiesBehindPlainPixelsOrAWholeElement) {
  EXPECT_FALSE(whole(kEightPixels.substr(0, 11)));
  expect_ends(kEightPixels + kShort + kLong, {12, 24, 42});
}

TEST(DicomEnd, OfElementsThatDoNotTellTheirKind) {
  expect_ends(kEightPixels + "\xE1\x7F\x10\0\x04\0\0\0word"s, {12, 24}, {.implicit = true});
}

TEST(DicomEnd, OfBigEndianElements) {
  expect_ends("\0\0\0\x08pixelsab\x7F\xE1\0\x10LO\0\x04word"s, {12, 24}, {.big_endian = true});
}

TEST(DicomEnd, LiesBehindAllFragments) {
  const std::string table = "\xFE\xFF\x00\xE0\0\0\0\0"s;
  const std::string fragment = "\xFE\xFF\x00\xE0\x04\0\0\0jpeg"s;
  const std::string end = "\xFE\xFF\xDD\xE0\0\0\0\0"s;
  const std::string packed = "\xFF\xFF\xFF\xFF"s + table + fragment + end;
  expect_ends(packed + kShort, {32, 44}, {.packed = true});
}

TEST(DicomEnd, OfSequencesThatDoNotTellTheirLength) {
  const std::string sequence = "\xE1\x7F\x10\0SQ\0\0\xFF\xFF\xFF\xFF"s;
  const std::string item =
      "\xFE\xFF\x00\xE0\xFF\xFF\xFF\xFF"s + kShort + "\xFE\xFF\x0D\xE0\0\0\0\0"s;
  const std::string told = "\xFE\xFF\x00\xE0\x0C\0\0\0"s + kShort;
  const std::string end = "\xFE\xFF\xDD\xE0\0\0\0\0"s;
  const std::string content = kEightPixels + sequence + item + told + end + kShort;
  const auto whole_at = content.size();
  EXPECT_TRUE(whole(content));
  EXPECT_TRUE(whole(content.substr(0, whole_at - kShort.size())));
  for (const std::size_t cut : {1U, 11U, 13U, 19U}) {
    EXPECT_FALSE(whole(content.substr(0, whole_at - cut))) << cut;
  }
}

TEST(DicomEnd, OfAFileWithoutPixels) {
  const std::string meta = std::string(128, '\0') + "DICM\x02\0\x10\0UI\x04\0"s + "1.2\0"s;
  const std::string content = meta + kShort + kLong;
  const study::TemporaryFolder folder;
  const auto file = folder.path() / "report";
  for (std::size_t size = meta.size(); size <= content.size(); ++size) {
    std::ofstream(file, std::ios::binary) << content.substr(0, size);
    const bool end =
        size == meta.size() || size == meta.size() + kShort.size() || size == content.size();
    EXPECT_EQ(is_whole(file, {}), end) << size;
  }
}

TEST(DicomEnd, MayBeFilledUpWithZeros) {
  EXPECT_TRUE(whole(kEightPixels + std::string(5, '\0')));
  EXPECT_TRUE(whole(kEightPixels + kShort + std::string(500, '\0')));
}

TEST(DicomEnd, IsNotLookedForWhereThatIsNotKnown) {
  EXPECT_TRUE(whole(kEightPixels + "\xE1\x7F\x10\0SQ\0\0\xFF\xFF\xFF\xFFnoitem.."s));
  EXPECT_TRUE(whole(kEightPixels + "\xE1\x7F\x10\0??\x04\0"s));
  EXPECT_TRUE(whole("\x04\0\0\0pixelsab\xE1\x7F"s)) << "a writer that tells another length";
}

TEST(DicomEnd, MayBeFollowedByWhatIsNoElement) {
  EXPECT_TRUE(whole(kEightPixels + "\n"));
  EXPECT_TRUE(whole(kEightPixels + kShort + "\r\n"));
  EXPECT_TRUE(whole(kEightPixels + "end\n"));
  EXPECT_FALSE(whole(kEightPixels + "\xE1\x7F\x10"s)) << "the start of a private element";
}

TEST(DicomEnd, MayLackTheMarkBehindAllFragments) {
  const std::string table = "\xFF\xFF\xFF\xFF\xFE\xFF\x00\xE0\0\0\0\0"s;
  const std::string fragment = "\xFE\xFF\x00\xE0\x04\0\0\0jp\xFF\xD9"s;
  const std::string open = "\xFE\xFF\x00\xE0\x04\0\0\0jpeg"s;
  EXPECT_TRUE(whole(table + fragment, {.packed = true, .frames = 1}));
  EXPECT_FALSE(whole(table + fragment, {.packed = true, .frames = 2}));
  EXPECT_FALSE(whole(table + open, {.packed = true, .frames = 1}));
  EXPECT_TRUE(whole(table + open, {.packed = true, .run_lengths = true, .frames = 1}));
}

}  // namespace
}  // namespace beatlas::ingest
