#include <gtest/gtest.h>

#include "pipeline/ingest/dicom_pixels.h"
#include "pipeline/ingest/dicom_scan.h"
#include "tests/unit/ingest/made_exam.h"

namespace beatlas::ingest {
namespace {

using test::all;
using test::decided;
using test::kRounding;
using test::MadeExam;

class Storage : public testing::TestWithParam<const char*> {};

TEST_P(Storage, GivesTheSameExam) {
  const MadeExam made(GetParam());
  const Exam exam = made.read();
  EXPECT_EQ(exam.stack.grid().size, (Index3{20, 16, 6})) << all(exam);
  EXPECT_EQ(exam.stack.phase_count(), 10);
  EXPECT_TRUE(exam.stack.grid().mm_from_index.isApprox(made.lps_from_index(), 1e-8));
  // 12 bits hold every fourth grey level.
  const double rounding = made.variant() == "twelve_bits" ? 2.01 : kRounding;
  EXPECT_LE(made.worst_error(exam.stack), rounding) << all(exam);
  EXPECT_NEAR(exam.stack.rr_interval_s, 0.9, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Forms, Storage,
                         testing::Values("deflated", "big_endian", "jpeg_lossless", "jpeg_ls",
                                         "jpeg_2000", "multi_jpeg_ls", "inverted", "twelve_bits",
                                         "float", "double", "ct", "unknown_modality", "same_uids",
                                         "doubled"),
                         [](const auto& test) { return std::string(test.param); });

TEST(Storage, WhatIsUnusualIsTold) {
  const Exam inverted = MadeExam("inverted").read();
  EXPECT_TRUE(decided(inverted, "Warning: 60 images have inverted grey levels")) << all(inverted);
  const Exam ct = MadeExam("ct").read();
  EXPECT_TRUE(decided(ct, "Warning: 60 images are of modality CT, not MR")) << all(ct);
  const Exam unknown = MadeExam("unknown_modality").read();
  EXPECT_TRUE(decided(unknown, "60 images are of modality unknown")) << all(unknown);
  EXPECT_FALSE(decided(unknown, "SECRET")) << all(unknown);
  const Exam uids = MadeExam("same_uids").read();
  EXPECT_TRUE(decided(uids, "59 images have the UID of another image")) << all(uids);
  const Exam doubled = MadeExam("doubled").read();
  EXPECT_TRUE(decided(doubled, "10 images equal to another were left")) << all(doubled);
}

TEST(Storage, OfTwoPatientsOneMustBeChosen) {
  const MadeExam made("two_patients");
  const std::string message = made.refusal();
  EXPECT_NE(message.find("2 exams of different patients, choose one with --exam N: 1. 72 images"),
            std::string::npos)
      << message;
  IngestOptions options;
  options.exam = 2;
  const Exam exam = made.read(options);
  EXPECT_EQ(exam.stack.phase_count(), 10);
  EXPECT_LE(made.worst_error(exam.stack), kRounding);
  EXPECT_FALSE(decided(exam, "SECRET")) << all(exam);
}

TEST(Storage, PackedFilesOfManyFramesAreDecodedOnce) {
  // What is kept needs its file no more.
  const MadeExam made("multi_jpeg_ls");
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(made.path())) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  StageContext context;
  const auto images = scan_dicom({made.path()}, files, false, context).images;
  ASSERT_FALSE(images.empty());
  DicomPixels pixels;
  for (const DicomImage& image : images) pixels.prepare(image, 1e9);
  for (const auto& file : files) std::filesystem::remove(file);
  std::vector<float> values(static_cast<std::size_t>(images[0].columns * images[0].rows));
  for (const DicomImage& image : images) {
    EXPECT_EQ(pixels.read(image, values), PixelState::Good);
  }
  pixels.release();
  EXPECT_EQ(pixels.read(images[0], values), PixelState::Damaged);
}

TEST(Storage, ImagesAreTakenFromTheSeriesAskedFor) {
  const MadeExam made("mixed");
  IngestOptions options;
  for (int series = 1; series <= 12; ++series) options.series.push_back(series);
  EXPECT_EQ(made.read(options).stack.grid().size[2], 12);
  options.series = {1234};
  EXPECT_NE(made.refusal(options).find("there are series 1-24, 201, 202, 301"), std::string::npos);
}

}  // namespace
}  // namespace beatlas::ingest
