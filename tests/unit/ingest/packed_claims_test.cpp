// Small DICOM files that claim to hold much, or inflate to it.
#include <fstream>

#include <gtest/gtest.h>

#include "pipeline/ingest/dicom_end.h"
#include "pipeline/ingest/dicom_file.h"
#include "pipeline/ingest/dicom_pixels.h"
#include "pipeline/ingest/inflated_file.h"
#include "pipeline/ingest/packed_frames.h"
#include "runtime/base/plausible_size.h"
#include "tests/unit/formats/image_bytes.h"
#include "tests/unit/formats/python_run.h"
#include "tests/unit/ingest/dicom_bytes.h"
#include "tests/unit/ingest/packed_frame.h"

namespace beatlas::ingest {
namespace {

using namespace beatlas::test;
using namespace std::string_literals;

constexpr std::size_t kMegabyte = 1'000'000;

FileHeader header_of(const DicomForm& form) {
  const Folder folder;
  std::ofstream(folder / "image", std::ios::binary) << dicom_file(form);
  IdentityWords words;
  return read_header(folder / "image", words);
}

/// A private element of zeros behind the pixels.
std::string padding(std::size_t bytes) {
  std::string head = "\xFC\xFF\xFC\xFFOB\0\0____"s;
  put(head, 8, static_cast<std::uint32_t>(bytes));
  return head + std::string(bytes, '\0');
}

void expect_refused(const FileHeader& header) {
  EXPECT_EQ(header.kind, FileHeader::Kind::Wrong);
  EXPECT_NE(header.problem.find("is believed to hold"), std::string::npos) << header.problem;
  EXPECT_TRUE(header.images.empty());
}

TEST(PackedClaims, DeflatedZerosAreBelievedToAStatedRatio) {
  for (const std::size_t sound : {std::size_t{0}, 60 * kMegabyte}) {
    EXPECT_EQ(header_of({.syntax = kDeflated, .behind = padding(sound)}).kind,
              FileHeader::Kind::Image);
  }
  expect_refused(header_of({.syntax = kDeflated, .behind = padding(150 * kMegabyte)}));
}

TEST(PackedClaims, WhatIsTooLargeIsNotKept) {
  const Folder folder;
  std::ofstream(folder / "image", std::ios::binary)
      << dicom_file({.syntax = kDeflated, .behind = padding(150 * kMegabyte)});
  const InflatedFile file(folder / "image");
  EXPECT_FALSE(file.good());
  EXPECT_TRUE(file.too_large());
  EXPECT_TRUE(file.path().empty());
}

TEST(PackedClaims, FramesOfPackedImagesTakeAFragmentEach) {
  const std::string frame = run_lengths(std::string(12, '\x07'));
  const DicomForm sound{.syntax = kRunLengths, .frames = 2, .bits = 8, .fragments = {frame, frame}};
  EXPECT_EQ(header_of(sound).kind, FileHeader::Kind::Image);
  DicomForm promises = sound;
  promises.frames = 3;
  EXPECT_EQ(header_of(promises).kind, FileHeader::Kind::Damaged);
}

TEST(PackedClaims, FewBytesDoNotHoldManyImages) {
  const std::string frame = run_lengths(std::string(12, '\x07'));
  DicomForm form{.syntax = kRunLengths, .frames = 100'000, .bits = 8, .fragments = {frame}};
  expect_refused(header_of(form));
  form.frames = 1000;
  form.rows = form.columns = 60'000;
  expect_refused(header_of(form));
  form.syntax = "1.2.3.4";  // private: nothing tells how much lies in it
  expect_refused(header_of(form));
  form.frames = 2'147'483'647;
  expect_refused(header_of(form));
}

TEST(PackedClaims, OfPlainImagesManyFramesTakeManyBytes) {
  const DicomForm sound{
      .columns = 1, .rows = 1, .frames = 50, .bits = 8, .pixels = std::string(50, 'p')};
  EXPECT_EQ(header_of(sound).images.size(), 50U);
  DicomForm promises = sound;
  promises.frames = 200'000;
  promises.pixels.resize(200'000);
  expect_refused(header_of(promises));
  promises.pixels.resize(100'000);
  EXPECT_EQ(header_of(promises).kind, FileHeader::Kind::Damaged);
}

/// Start of a JPEG, JPEG-LS or JPEG 2000 frame.
std::string jpeg_head(int columns, int rows, char kind = '\xC2', char components = 1) {
  const auto byte = [](int value) { return static_cast<char>(value & 0xFF); };
  return "\xFF\xD8\xFF\xE0\x00\x04__"s + "\xFF"s + kind + "\x00\x0B\x08"s + byte(rows >> 8) +
         byte(rows) + byte(columns >> 8) + byte(columns) + components + "\x01\x11\x00\xFF\xDA"s;
}
std::string jpeg_2000_head(std::uint32_t columns, std::uint32_t rows, std::uint32_t tile = 64,
                           char components = 1) {
  std::string out = "\xFF\x4F\xFF\x51\x00\x29\x00\x00"s + std::string(32, '\0') + "\0"s +
                    components + std::string(100, '_');
  put(out, 8, columns, true);
  put(out, 12, rows, true);
  put(out, 24, tile, true);
  put(out, 28, tile, true);
  return out;
}

TEST(PackedClaims, AFrameThatIsLargerThanItsImageReachesNoDecoder) {
  for (const char kind : {'\xC0', '\xC1', '\xC2', '\xC3', '\xF7'}) {
    EXPECT_TRUE(frame_fits(jpeg_head(40, 30, kind), 40, 30));
    EXPECT_TRUE(frame_fits(jpeg_head(4, 3, kind), 40, 30)) << "left to the decoder";
    EXPECT_FALSE(frame_fits(jpeg_head(41, 30, kind), 40, 30));
    EXPECT_FALSE(frame_fits(jpeg_head(40, 65535, kind), 40, 30));
    EXPECT_FALSE(frame_fits(jpeg_head(40, 30, kind, '\x7F'), 40, 30));
    const std::string later = "\xFF\xD8\xFF\xFF\xDB\x00\x03."s;
    EXPECT_FALSE(frame_fits(later + jpeg_head(41, 30, kind).substr(2), 40, 30));
  }
  EXPECT_TRUE(frame_fits(jpeg_2000_head(40, 30), 40, 30));
  EXPECT_FALSE(frame_fits(jpeg_2000_head(41, 30), 40, 30));
  EXPECT_FALSE(frame_fits(jpeg_2000_head(40, 0xFFFFFFFF), 40, 30));
  EXPECT_FALSE(frame_fits(jpeg_2000_head(40, 30, 1), 40, 30)) << "1200 tiles in 142 bytes";
  EXPECT_FALSE(frame_fits(jpeg_2000_head(40, 30, 0), 40, 30));
  EXPECT_FALSE(frame_fits(jpeg_2000_head(40, 30, 64, '\x7F'), 40, 30));
  EXPECT_FALSE(frame_fits("\0\0\0\x0CjP  ...."s + jpeg_2000_head(41, 30), 40, 30));
  EXPECT_TRUE(frame_fits("no frame", 40, 30)) << "left to the decoder";
}

TEST(PackedClaims, FramesAreLookedAtAcrossTheirFragments) {
  const Folder folder;
  const std::string large = jpeg_head(60'000, 60'000);
  const std::string whole = jpeg_head(4, 3);
  const auto fits = [&](const std::vector<std::string>& fragments) {
    const std::string bytes = dicom_file({.syntax = kJpeg, .bits = 8, .fragments = fragments});
    std::ofstream(folder / "image", std::ios::binary) << bytes;
    const auto pixels = static_cast<std::int64_t>(bytes.find("\xFE\xFF\x00\xE0"s));
    return packed_frames_fit(folder / "image", pixels, 4, 3);
  };
  EXPECT_TRUE(fits({whole}));
  EXPECT_TRUE(fits({whole.substr(0, 10), whole.substr(10)}));
  EXPECT_FALSE(fits({large}));
  EXPECT_FALSE(fits({whole, large}));
  EXPECT_FALSE(fits({large.substr(0, 10), large.substr(10)}));
  EXPECT_FALSE(fits({large.substr(0, 3), large.substr(3, 9), large.substr(12)}));
}

std::vector<PixelState> states_of(const DicomForm& form, std::vector<float>& values) {
  const Folder folder;
  std::ofstream(folder / "image", std::ios::binary) << dicom_file(form);
  IdentityWords words;
  const FileHeader header = read_header(folder / "image", words);
  EXPECT_EQ(header.kind, FileHeader::Kind::Image);
  DicomPixels pixels;
  std::vector<PixelState> out;
  for (const DicomImage& image : header.images) {
    pixels.prepare(image, 1e6);
    values.resize(static_cast<std::size_t>(image.rows * image.columns));
    out.push_back(pixels.read(image, values));
  }
  return out;
}

TEST(PackedClaims, SoundFramesGiveTheirPixels) {
  for (const PackedFrame& frame : packed_frames()) {
    std::vector<float> values;
    EXPECT_EQ(
        states_of({.syntax = frame.syntax, .bits = frame.bits, .fragments = {frame.bytes}}, values),
        std::vector{PixelState::Good})
        << frame.syntax;
    const float step = frame.bits == 8 ? 17 : 300;
    for (std::size_t n = 0; n < values.size(); ++n) {
      // Some of the kinds are lossy.
      EXPECT_NEAR(values[n], step * static_cast<float>(n), 0.2F * step) << frame.syntax;
    }
  }
}

TEST(PackedClaims, ADecoderThatEndsItsProcessEndsNothingElse) {
  // Three fragments for two frames: an assertion of GDCM's ends the process that asks for them.
  const PackedFrame frame = packed_frames().front();
  const DicomForm form{
      .syntax = frame.syntax,
      .frames = 2,
      .bits = frame.bits,
      .fragments = {frame.bytes.substr(0, 20), frame.bytes.substr(20), frame.bytes}};
  std::vector<float> values;
  EXPECT_EQ(states_of(form, values), (std::vector{PixelState::Damaged, PixelState::Damaged}));
}

TEST(PackedClaims, AFileCutAnywhereIsTold) {
  // vtk-dicom alone runs out of its memory where the mark behind the last fragment is cut.
  const Folder folder;
  const PackedFrame frame = packed_frames().front();
  const std::string whole =
      dicom_file({.syntax = frame.syntax, .bits = frame.bits, .fragments = {frame.bytes}});
  constexpr std::size_t kMark = 8;
  for (std::size_t size = 1; size <= whole.size(); ++size) {
    std::ofstream(folder / "image", std::ios::binary) << whole.substr(0, size);
    if (size > whole.size() - kMark) {
      EXPECT_EQ(is_understood(folder / "image"), size == whole.size()) << size;
    }
    IdentityWords words;
    const bool image = read_header(folder / "image", words).kind == FileHeader::Kind::Image;
    EXPECT_EQ(image, size == whole.size() || size == whole.size() - kMark) << size;
  }
}

TEST(PackedClaims, TheRuleNeitherOverflowsNorFallsWithSize) {
  std::uint64_t last = 0;
  for (int bit = 0; bit < 64; ++bit) {
    const std::uint64_t now = plausible_bytes(std::uint64_t{1} << bit, kImageUnpack);
    EXPECT_GE(now, last) << bit;
    EXPECT_LE(now, kImageUnpack.most) << bit;
    last = now;
  }
  EXPECT_EQ(last, kImageUnpack.most);
  EXPECT_EQ(plausible_bytes(0, kImageUnpack), kImageUnpack.floor);
}

}  // namespace
}  // namespace beatlas::ingest
