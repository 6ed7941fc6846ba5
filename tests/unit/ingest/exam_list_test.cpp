#include "pipeline/ingest/exam_list.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "tests/unit/ingest/made_images.h"

namespace beatlas::ingest::exam_list_tests {
namespace {

using test::append;
using test::made_stack;
using test::MadeStack;
using test::told;

bool six_slices(const std::vector<DicomImage>& images) { return images.size() >= 60; }

ExamChoice choose(const std::vector<DicomImage>& images, int exam = 0,
                  const std::vector<int>& series = {}) {
  return choose_exam(images, exam, series, six_slices, test::no_files());
}

std::string refusal(const std::vector<DicomImage>& images, int exam = 0,
                    const std::vector<int>& series = {}) {
  try {
    (void)choose(images, exam, series);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
    return error.what();
  }
  return "was chosen";
}

TEST(ExamList, StudiesPerSeriesThatShareAFrameOfReferenceAreOneExam) {
  auto images = made_stack({});
  for (DicomImage& image : images) image.study_uid = "study of " + image.series_uid;
  EXPECT_EQ(list_exams(images).size(), 1U);
  for (DicomImage& image : images) image.frame_of_reference_uid = "frame of " + image.series_uid;
  EXPECT_EQ(list_exams(images).size(), 6U);
  for (DicomImage& image : images) image.study_uid = image.frame_of_reference_uid = "";
  EXPECT_EQ(list_exams(images).size(), 1U);
  for (DicomImage& image : images) image.patient = "";
  EXPECT_EQ(list_exams(images).size(), 1U);
}

TEST(ExamList, ImagesWithoutAPatientBelongToTheOnlyOneOfTheirStudy) {
  auto images = made_stack({});
  images[3].patient = "";
  EXPECT_EQ(list_exams(images).size(), 1U);
  auto others = made_stack({.slices = 3,
                            .first_series = 50,
                            .patient = "ID2\nNAME2",
                            .study = "other",
                            .frame = "other"});
  append(images, others);
  EXPECT_EQ(list_exams(images).size(), 2U);
  // A study's UID that two patients share links nobody.
  for (DicomImage& image : images) image.study_uid = image.frame_of_reference_uid = "same";
  const auto exams = list_exams(images);
  ASSERT_EQ(exams.size(), 3U);
  EXPECT_EQ(exams[2].images.size(), 1U);
}

TEST(ExamList, TheOrderIsThatOfTheContent) {
  auto images = made_stack({.slices = 3, .first_series = 50, .patient = "A\nA", .study = "a"});
  append(images, made_stack({.patient = "Z\nZ", .study = "z"}));
  auto turned = images;
  std::reverse(turned.begin(), turned.end());
  for (DicomImage& image : turned) image.file = "x" + image.file.string();
  for (const auto& some : {images, turned}) {
    const auto exams = list_exams(some);
    ASSERT_EQ(exams.size(), 2U);
    EXPECT_EQ(exams[0].patient, "Z\nZ");
    EXPECT_EQ(exams[0].images.size(), 60U);
  }
}

TEST(ExamList, BetweenPatientsThereIsNoGuess) {
  auto images = made_stack({});
  append(images, made_stack({.slices = 1,
                             .phases = 2,
                             .first_series = 90,
                             .pixels = 32,
                             .patient = "ID2\nOTHER",
                             .study = "secret",
                             .frame = "hidden"}));
  const std::string message = refusal(images);
  EXPECT_EQ(message,
            "it holds 2 exams of different patients, choose one with --exam N: 1. 60 images of "
            "series 1-6 (6 in all), 64 x 64 pixels, 6 slices x 10 phases, 8.00 mm apart, axial, "
            "one of them s1_0; 2. 2 images of series 90, 32 x 32 pixels, one of them s90_0");
  const ExamChoice second = choose(images, 2);
  EXPECT_EQ(second.images.size(), 2U);
  EXPECT_TRUE(told(second.decisions, "Exam 2 of 2 was taken, as asked."));
  EXPECT_NE(refusal(images, 3).find("there is no exam 3"), std::string::npos);
  // Another patient's images out of the way, there is no question.
  EXPECT_EQ(choose(images, 0, {1, 2, 3}).images.size(), 30U);
}

std::vector<DicomImage> in_folder(const std::string& folder, std::vector<DicomImage> images) {
  for (DicomImage& image : images) {
    image.file = folder + "/se" + image.series_uid + "/" + image.file.string();
  }
  return images;
}

TEST(ExamList, ExamsThatLookAlikeAreToldApartByTheirFolders) {
  const MadeStack other{.patient = "ID2\nOTHER", .study = "secret", .frame = "hidden"};
  auto images = in_folder("a", made_stack({}));
  append(images, in_folder("b", made_stack(other)));
  std::string message = refusal(images);
  EXPECT_NE(message.find("axial, in b; 2. "), std::string::npos) << message;
  EXPECT_NE(message.find("axial, in a"), std::string::npos) << message;
  // One within the other's folder: the outer one is no place of its own.
  images = in_folder("a", made_stack({}));
  append(images, in_folder("a/b", made_stack(other)));
  message = refusal(images);
  EXPECT_NE(message.find("axial, one of them a/se1/s1_0"), std::string::npos) << message;
  EXPECT_NE(message.find("axial, in a/b"), std::string::npos) << message;
  EXPECT_EQ(message.find("secret"), std::string::npos) << message;
}

TEST(ExamList, OfOnePatientsStudiesTheOnlyOneWithAStackIsTaken) {
  auto images = made_stack({.slices = 2, .first_series = 50, .study = "before", .frame = "b"});
  append(images, made_stack({}));
  const ExamChoice choice = choose(images);
  EXPECT_EQ(choice.images.size(), 60U);
  EXPECT_TRUE(told(choice.decisions, "2 studies of one patient; only one holds a stack"));
  append(images, made_stack({.first_series = 100, .study = "after", .frame = "a"}));
  EXPECT_NE(refusal(images).find("3 exams of one patient"), std::string::npos);
  EXPECT_EQ(choose(images, 3).images.size(), 20U);
}

TEST(ExamList, StudiesThatMakeAStackOnlyTogetherAreTakenTogetherAndTold) {
  auto images = made_stack({});
  for (DicomImage& image : images) {
    image.study_uid = image.series_uid;
    image.frame_of_reference_uid = "f" + image.series_uid;
  }
  const ExamChoice choice = choose(images);
  EXPECT_EQ(choice.images.size(), 60U);
  EXPECT_TRUE(told(choice.decisions, "Warning: there are 6 studies of one patient"));
  for (DicomImage& image : images) image.patient = "";
  EXPECT_NE(refusal(images).find("6 exams"), std::string::npos) << "who knows whose they are";
}

TEST(ExamList, SeriesThatDoNotExistAreAnsweredWithThoseThatDo) {
  const auto images = made_stack({});
  EXPECT_EQ(choose(images, 0, {2, 4, 77}).images.size(), 20U);
  EXPECT_NE(refusal(images, 0, {77}).find("there are series 1-6"), std::string::npos);
}

TEST(ExamList, ABlankNameContradictsNone) {
  auto images = made_stack({});
  for (DicomImage& image : images) {
    if (image.series_number == 3) image.patient = "ID\n";
    if (image.series_number == 4) image.patient = "\nNAME";
  }
  EXPECT_EQ(list_exams(images).size(), 1U);
  // Of two names under one ID it may be either: no guess.
  for (DicomImage& image : images) {
    if (image.series_number > 4) image.patient = "ID\nOTHER";
  }
  EXPECT_EQ(list_exams(images).size(), 3U);
}

}  // namespace
}  // namespace beatlas::ingest::exam_list_tests
