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

TEST(DicomEnd, MayBeFilledUpWithZeros) {
  EXPECT_TRUE(whole(kEightPixels + std::string(5, '\0')));
  EXPECT_TRUE(whole(kEightPixels + kShort + std::string(500, '\0')));
}

TEST(DicomEnd, IsNotLookedForWhereThatIsNotKnown) {
  EXPECT_TRUE(whole(kEightPixels + "\xE1\x7F\x10\0SQ\0\0\xFF\xFF\xFF\xFFitems"s));
  EXPECT_TRUE(whole(kEightPixels + "\xE1\x7F\x10\0??\x04\0"s));
  EXPECT_TRUE(whole("\x04\0\0\0pixelsab\xE1\x7F"s)) << "a writer that tells another length";
}

}  // namespace
}  // namespace beatlas::ingest
