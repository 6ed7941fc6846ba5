// Voxels in several files beside a header: each part must hold its share, no less and no more.

#include <fstream>

#include <gtest/gtest.h>

#include "pipeline/formats/image_file.h"
#include "runtime/base/error.h"
#include "tests/unit/formats/image_bytes.h"
#include "tests/unit/formats/python_run.h"

namespace beatlas::formats {
namespace {

using namespace beatlas::test;

/// A header of 10 images with a file for each, as both formats write it.
class DataParts : public testing::Test {
 protected:
  DataParts() {
    const std::string voxels = stored(object_.voxels(), "i2");
    const std::size_t share = voxels.size() / 10;
    for (std::size_t p = 0; p < 10; ++p) parts_.push_back(voxels.substr(p * share, share));
  }
  /// What each format says of these parts; they must say the same.
  std::string read(const std::string& encoding = "raw", const std::string& more = "") {
    std::string names;
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      const std::string name = "part" + std::to_string(p + 1) + ".raw";
      std::ofstream(folder_ / name, std::ios::binary) << parts_[p];
      names += name + "\n";
    }
    const std::string count = std::to_string(parts_.size());
    const std::string nrrd =
        nrrd_header(object_.grid, 10) + more + "encoding: " + encoding + "\ndata file: ";
    const std::string listed = read_file("a.nhdr", nrrd + "LIST\n" + names);
    const std::string pattern = "part%d.raw 1 " + count + " 1\n";
    EXPECT_EQ(read_file("a.nhdr", nrrd + pattern), listed);
    if (encoding == "raw" && more.empty()) {
      const std::string meta = meta_header(object_.grid, 10) + "ElementDataFile = ";
      EXPECT_EQ(read_file("a.mhd", meta + "LIST\n" + names).substr(5), listed.substr(6));
      EXPECT_EQ(read_file("a.mhd", meta + pattern).substr(5), listed.substr(6));
    }
    return listed;
  }
  std::string read_file(const std::string& name, const std::string& header) {
    std::ofstream(folder_ / name, std::ios::binary) << header;
    try {
      const ImageFile file = read_image_file(folder_ / name);
      std::vector<double> values;
      for (const auto& phase : file.images.phases) {
        values.insert(values.end(), phase.begin(), phase.end());
      }
      return name + (values == object_.voxels() ? ": whole" : ": other voxels");
    } catch (const Error& error) {
      const std::string message = error.what();
      return message.substr(message.find(name));
    }
  }
  void expect_refusal(const std::string& said, const std::string& words) {
    EXPECT_NE(said.find(words), std::string::npos) << said;
  }

  Folder folder_;
  Beating object_ = oblique_object();
  std::vector<std::string> parts_;
};

TEST_F(DataParts, AllWholeAreRead) {
  EXPECT_EQ(read(), "a.nhdr: whole");
  for (std::string& part : parts_) part = "ab\n" + part;
  EXPECT_EQ(read("raw", "line skip: 1\n"), "a.nhdr: whole");
  EXPECT_EQ(read("raw", "byte skip: 3\n"), "a.nhdr: whole");
  EXPECT_EQ(read("raw", "byte skip: -1\n"), "a.nhdr: whole");
}

TEST_F(DataParts, WhatOneLacksAndTheNextHasTooMuchIsNoWholeCine) {
  parts_[3].resize(parts_[3].size() - 200);
  parts_[4] += std::string(200, '\0');
  expect_refusal(read(), "data file 4 of the 10 that its header names is shorter");
  expect_refusal(read("raw", "byte skip: -1\n"), "data file 4 of the 10");
}

TEST_F(DataParts, OneThatIsTooLongIsRefused) {
  parts_[7] += 'x';
  expect_refusal(read(), "data file 8 of the 10 that its header names is longer");
}

TEST_F(DataParts, TooManyOrTooFewAreRefused) {
  parts_.insert(parts_.begin(), parts_[9]);
  expect_refusal(read(), "11 data files for 10 images");
  parts_.resize(9);
  expect_refusal(read(), "9 data files for 10 images");
  parts_.resize(5);  // of a length that five files might have
  expect_refusal(read(), "data file 1 of the 5 that its header names is shorter");
}

TEST_F(DataParts, PackedOnesTooHoldTheirShare) {
  const auto packed = [this] {
    const std::vector<std::string> plain = parts_;
    for (std::string& part : parts_) part = gzip(part);
    const std::string said = read("gzip");
    parts_ = plain;
    return said;
  };
  EXPECT_EQ(packed(), "a.nhdr: whole");
  parts_[3].resize(parts_[3].size() - 200);
  parts_[4] += std::string(200, '\0');
  expect_refusal(packed(), "data file 4 of the 10 that its header names is shorter");
  parts_[3] += std::string(400, '\0');
  expect_refusal(packed(), "data file 4 of the 10 that its header names is longer");
}

TEST_F(DataParts, NumbersAsWordsEndWithTheirFile) {
  const auto values = object_.voxels();
  const auto share = static_cast<std::ptrdiff_t>(object_.grid.count());
  for (std::ptrdiff_t p = 0; p < 10; ++p) {
    std::string text =
        stored({values.begin() + p * share, values.begin() + (p + 1) * share}, "text");
    while (text.back() == ' ' || text.back() == '\n') text.pop_back();
    parts_[static_cast<std::size_t>(p)] = text;
  }
  EXPECT_EQ(read("ascii"), "a.nhdr: whole");
  parts_[9] += " 7";
  expect_refusal(read("ascii"), "data file 10 of the 10 that its header names is longer");
}

}  // namespace
}  // namespace beatlas::formats
