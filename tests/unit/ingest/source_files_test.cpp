#include "pipeline/ingest/source_files.h"

#include <algorithm>
#include <fstream>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "tests/unit/formats/python_run.h"

namespace beatlas::ingest {
namespace {

using beatlas::test::Folder;

TEST(NaturalOrder, NumbersCountAsNumbers) {
  std::vector<std::string> names{"phase_10", "phase_2", "phase_1", "phase_02", "a",
                                 "phase_2b", "Phase_1", "phase_",  "",         "phase_0010"};
  std::sort(names.begin(), names.end(), natural_less);
  EXPECT_EQ(names, (std::vector<std::string>{"", "Phase_1", "a", "phase_", "phase_1", "phase_02",
                                             "phase_2", "phase_2b", "phase_0010", "phase_10"}));
  for (const std::string& a : names) {
    for (const std::string& b : names) EXPECT_EQ(natural_less(a, b), a != b && !natural_less(b, a));
  }
}

class Sources : public testing::Test {
 protected:
  std::filesystem::path touch(const std::string& name, const std::string& text = "x") {
    std::filesystem::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  SourceFiles find(const std::vector<std::filesystem::path>& sources) {
    StageContext context;
    return find_files(sources, context);
  }
  std::string refusal(const std::vector<std::filesystem::path>& sources) {
    try {
      (void)find(sources);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
      return error.what();
    }
    return "found";
  }
  Folder folder_;
  const std::string dicom_ = std::string(128, '\0').append("DICM");
};

TEST_F(Sources, FolderOfImagesIsAListInNaturalOrder) {
  for (const char* name : {"p10.nii", "p2.nii", "p1.nii", "p1.json", ".hidden"}) touch(name);
  touch("q.mhd");
  touch("q.raw");
  const SourceFiles found = find({folder_.path()});
  EXPECT_EQ(found.images, (std::vector{folder_ / "p1.nii", folder_ / "p2.nii", folder_ / "p10.nii",
                                       folder_ / "q.mhd"}));
  EXPECT_FALSE(found.named);
  EXPECT_EQ(found.left, 1) << "the .json";
}

TEST_F(Sources, FilesOfAStudyBelowTheFolderAreLeft) {
  const std::string record =
      std::string(R"({"stages": {)").append(9000, ' ').append(R"(}, "study_format": 1})");
  touch("p1.nii");
  touch("a/exam.study/study.json", record);
  touch("a/exam.study/exam/stack.nii.gz");
  touch("a/exam.study/deep/er/b", dicom_);
  touch("b/study.json", R"({"another": "program's"})");
  touch("b/p2.nii");
  SourceFiles found = find({folder_.path()});
  EXPECT_EQ(found.images, (std::vector{folder_ / "b/p2.nii", folder_ / "p1.nii"}));
  EXPECT_EQ(found.studies, 1);
  // What lies in it, if that is what the user named; the study itself is no source.
  const std::vector stack{folder_ / "a/exam.study/exam/stack.nii.gz"};
  EXPECT_EQ(find({folder_ / "a/exam.study/exam"}).images, stack);
  EXPECT_EQ(find(stack).images, stack);
  const std::vector study{folder_ / "a/exam.study"};
  const std::string said = refusal(study);
  const std::string named = study.front().string();
  EXPECT_EQ(said.rfind(named + ": it is a study", 0), 0U) << said;
  EXPECT_NE(said.find("'beatlas build --study " + named + "'"), std::string::npos) << said;
  touch("c", dicom_);
  found = find({folder_.path()});
  EXPECT_EQ(found.dicom.size(), 4U) << "DICOM too";
  EXPECT_EQ(found.studies, 1);
}

TEST_F(Sources, HiddenFilesThatWereFoundAreNoImages) {
  touch("mac/cine.nii.gz");
  touch("mac/._cine.nii.gz", "Mac OS X");
  touch("mac/.old.nii.gz");
  const SourceFiles found = find({folder_ / "mac"});
  EXPECT_EQ(found.images, std::vector{folder_ / "mac/cine.nii.gz"});
  EXPECT_EQ(found.left, 0);
  EXPECT_EQ(find({folder_ / "mac/.old.nii.gz"}).images.size(), 1U) << "named, it is one";
  touch("dicom/IM1", dicom_);
  touch("dicom/._IM1", "Mac OS X");
  EXPECT_EQ(find({folder_ / "dicom"}).dicom, std::vector{folder_ / "dicom/IM1"});
}

TEST_F(Sources, FolderWithDicomIsDicom) {
  touch("a.nii");
  touch("b", dicom_);
  const SourceFiles found = find({folder_.path()});
  EXPECT_TRUE(found.images.empty());
  EXPECT_EQ(found.dicom.size(), 2U);
}

TEST_F(Sources, DicomUnderTheNameOfAnImageIsDicom) {
  touch("IM1.img", dicom_);
  EXPECT_TRUE(find({folder_.path()}).images.empty());
  EXPECT_EQ(find({folder_ / "IM1.img"}).dicom.size(), 1U);
}

TEST_F(Sources, NamedFilesKeepTheirOrder) {
  const auto a = touch("a.nii");
  const auto b = touch("b.nrrd");
  const SourceFiles found = find({b, a});
  EXPECT_EQ(found.images, (std::vector{b, a}));
  EXPECT_TRUE(found.named);
}

TEST_F(Sources, WhatDoesNotGoTogetherIsRefused) {
  const auto image = touch("a.nii");
  const auto dicom = touch("d/x", dicom_);
  EXPECT_NE(refusal({image, dicom}).find("not both"), std::string::npos);
  EXPECT_NE(refusal({image, folder_ / "d"}).find("not both"), std::string::npos);
  EXPECT_NE(refusal({touch("exam.TAR.GZ")}).find("unpack"), std::string::npos);
  touch("z/exam.zip");
  EXPECT_NE(refusal({folder_ / "z"}).find("archives only"), std::string::npos);
  EXPECT_NE(refusal({}).find("no source"), std::string::npos);
}

}  // namespace
}  // namespace beatlas::ingest
