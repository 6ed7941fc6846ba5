// Exams from NRRD, MetaImage and lists of files; NIfTI is in read_nifti_test.

#include <fstream>

#include <gtest/gtest.h>

#include "pipeline/ingest/ingest.h"
#include "runtime/base/error.h"
#include "tests/unit/formats/image_bytes.h"
#include "tests/unit/ingest/made_exam.h"

namespace beatlas::ingest {
namespace {

using namespace beatlas::test;
using test::decided;
namespace fs = std::filesystem;

/// Frame p alone.
std::string frame(const Beating& object, int p) {
  const auto all = object.voxels();
  const auto count = static_cast<std::ptrdiff_t>(object.grid.count());
  return stored({all.begin() + count * p, all.begin() + count * (p + 1)}, "i2");
}

class ReadImages : public testing::Test {
 protected:
  fs::path write(const std::string& name, const std::string& bytes) {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }
  fs::path nrrd(const std::string& name, int p) {
    return write(name, nrrd_header(object_.grid, 1) + "encoding: raw\n\n" + frame(object_, p));
  }
  fs::path meta(const std::string& name, int p) {
    return write(name,
                 meta_header(object_.grid, 1) + "ElementDataFile = LOCAL\n" + frame(object_, p));
  }
  fs::path sequence(const std::string& fields) {
    return write("a.seq.nrrd", nrrd_header(object_.grid, 10, true) + fields + "encoding: gzip\n\n" +
                                   gzip(stored(frames_first(object_.voxels(), 10), "i2")));
  }
  Exam read(const std::vector<fs::path>& sources, const IngestOptions& options = {}) {
    StageContext context;
    return read_exam(sources, options, context);
  }
  std::string refusal(const std::vector<fs::path>& sources, const IngestOptions& options = {}) {
    try {
      (void)read(sources, options);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
      return error.what();
    }
    return "was read";
  }
  /// Phase p must show the object at frame p.
  void expect_object(const Exam& exam, int first = 0) {
    const Grid& grid = exam.stack.grid();
    double worst = 0;
    for (int p = 0; p < exam.stack.phase_count(); ++p) {
      for (int k = 0; k < grid.size[2]; ++k) {
        for (int j = 0; j < grid.size[1]; ++j) {
          for (int i = 0; i < grid.size[0]; ++i) {
            const double seen =
                exam.stack.images.phases[static_cast<std::size_t>(p)][grid.offset(i, j, k)];
            worst = std::max(worst, std::abs(seen - object_.value(grid.mm(i, j, k), p + first)));
          }
        }
      }
    }
    EXPECT_LE(worst, test::kRounding);
  }
  Folder folder_;
  Beating object_ = oblique_object();
};

TEST_F(ReadImages, SequenceWithIndexValues) {
  const Exam exam = read({sequence(
      "labels: \"time\" \"\" \"\" \"\"\nunits: \"ms\" \"\" \"\" \"\"\nkinds: list domain domain "
      "domain\naxis 0 index type:=numeric\n"
      "axis 0 index values:=0 90 180 270 360 450 540 630 720 810\n")});
  EXPECT_EQ(exam.source_format, "nrrd");
  EXPECT_NEAR(exam.stack.rr_interval_s, 0.9, 1e-9);
  EXPECT_NEAR(exam.stack.frame_times_s.at(4), 0.36, 1e-9);
  expect_object(exam);
}

TEST_F(ReadImages, UnevenTimesAreResampledToEvenPhases) {
  // The frames of phases 0, .1, ... .9 were taken at other times than they stand for: at even
  // phases the images between are blends, and only phase 0 is the file's own.
  const Exam exam =
      read({sequence("units: \"s\" \"\" \"\" \"\"\n"
                     "axis 0 index values:=0 0.05 0.1 0.2 0.3 0.4 0.5 0.6 0.7 0.8\n")},
           {.rr_interval_s = 1});
  EXPECT_TRUE(decided(exam, "resampled to 10 even phases"));
  EXPECT_TRUE(decided(exam, "unevenly spread"));
  const auto all = object_.voxels();
  const std::size_t count = object_.grid.count();
  const std::size_t centre = object_.grid.offset(5, 10, 2);
  EXPECT_EQ(exam.stack.images.phases[0][centre], all[centre]);
  // Phase 0.1 was taken: it is the third image; phase 0.9 lies between the last and the first.
  EXPECT_EQ(exam.stack.images.phases[1][centre], all[2 * count + centre]);
  EXPECT_NE(exam.stack.images.phases[9][centre], all[9 * count + centre]);
}

TEST_F(ReadImages, ListAxisWithoutTimeNeedsTheRrInterval) {
  const fs::path file = sequence("");
  EXPECT_NE(refusal({file}).find("a.seq.nrrd: it does not tell the time"), std::string::npos);
  EXPECT_NE(refusal({file}).find("--rr SECONDS"), std::string::npos);
  expect_object(read({file}, {.rr_interval_s = 0.8}));
}

TEST_F(ReadImages, AxisThatIsNoTimeIsRefused) {
  const fs::path file = sequence("kinds: vector domain domain domain\n");
  EXPECT_NE(refusal({file}, {.rr_interval_s = 0.8}).find("not the time of a cine"),
            std::string::npos);
}

TEST_F(ReadImages, MetaImageOfFourDimensions) {
  const fs::path file = write("a.mha", meta_header(object_.grid, 10) + "ElementDataFile = LOCAL\n" +
                                           stored(object_.voxels(), "i2"));
  const Exam exam = read({file});
  EXPECT_EQ(exam.source_format, "metaimage");
  EXPECT_NEAR(exam.stack.rr_interval_s, 0.9, 1e-9);
  EXPECT_TRUE(decided(exam, "no unit of time"));
  expect_object(exam);
}

TEST_F(ReadImages, ListOfNamedFilesIsInTheOrderGiven) {
  std::vector<fs::path> files;
  for (int p = 0; p < 10; ++p) {
    const std::string name = std::to_string(9 - p);
    files.push_back(p % 2 == 0 ? nrrd(name + ".nrrd", p) : meta(name + ".mha", p));
  }
  EXPECT_NE(refusal(files).find("--rr SECONDS"), std::string::npos);
  const Exam exam = read(files, {.rr_interval_s = 0.8});
  EXPECT_EQ(exam.stack.rr_interval_s, 0.8);
  EXPECT_TRUE(decided(exam, "in the order given"));
  expect_object(exam);
}

TEST_F(ReadImages, FolderOfThreeDimensionalFilesIsInNaturalOrder) {
  for (int p = 0; p < 10; ++p) nrrd(std::to_string(p + 1) + "_phase.nrrd", p);
  const Exam exam = read({folder_.path()}, {.rr_interval_s = 0.8});
  EXPECT_TRUE(decided(exam, "in the order of their names"));
  expect_object(exam);
}

TEST_F(ReadImages, StudyInTheFolderIsLeftAndTold) {
  write("a.mha", meta_header(object_.grid, 10) + "ElementDataFile = LOCAL\n" +
                     stored(object_.voxels(), "i2"));
  fs::create_directory(folder_ / "exam.study");
  write("exam.study/study.json", R"({"stages": {}, "study_format": 1})");
  nrrd("exam.study/stack.nrrd", 0);
  const Exam exam = read({folder_.path()});
  EXPECT_TRUE(decided(exam, "1 study in the folder was left"));
  EXPECT_TRUE(decided(exam, "the R-R interval is 900 ms"));
  expect_object(exam);
}

TEST_F(ReadImages, NameThatBreaksALineIsShownInOne) {
  const std::string said = refusal({nrrd("a\nb.nrrd", 0)});
  EXPECT_NE(said.find("a?b.nrrd: it holds one image only"), std::string::npos) << said;
}

TEST_F(ReadImages, ListIsToldAsOne) {
  object_.grid.size[2] = 1;
  std::vector<fs::path> files;
  for (const int p : {0, 1, 2}) files.push_back(nrrd(std::to_string(p) + ".nrrd", p));
  const std::string said = refusal(files);
  EXPECT_TRUE(said.starts_with("the list of 3 files that begins with ")) << said;
  EXPECT_NE(said.find("0.nrrd: it holds 1 slice, at least 3"), std::string::npos) << said;
}

TEST_F(ReadImages, FolderWithOneFileIsThatFile) {
  write("a.mha", meta_header(object_.grid, 10) + "ElementDataFile = LOCAL\n" +
                     stored(object_.voxels(), "i2"));
  expect_object(read({folder_.path()}));
}

TEST_F(ReadImages, LabelsAmongImagesAreNoPhases) {
  std::vector<fs::path> files;
  for (int p = 0; p < 4; ++p) files.push_back(nrrd("frame" + std::to_string(p) + ".nrrd", p));
  EXPECT_EQ(read(files, {.rr_interval_s = 1}).stack.phase_count(), 4);
  std::vector<double> labels(object_.grid.count());
  for (std::size_t v = 0; v < labels.size(); ++v) labels[v] = static_cast<double>(v % 4);
  files.insert(files.begin() + 2,
               write("frame1_gt.nrrd",
                     nrrd_header(object_.grid, 1) + "encoding: raw\n\n" + stored(labels, "i2")));
  const std::string message = refusal(files, {.rr_interval_s = 1});
  EXPECT_NE(message.find("frame1_gt.nrrd: it holds labels"), std::string::npos) << message;
}

TEST_F(ReadImages, FilesThatDoNotFitAreRefused) {
  const fs::path first = nrrd("a.nrrd", 0);
  const fs::path second = nrrd("b.nrrd", 1);
  EXPECT_NE(refusal({first}).find("one image only"), std::string::npos);

  Beating other = object_;
  other.grid.size[0] = 10;
  const fs::path small =
      write("c.nrrd", nrrd_header(other.grid, 1) + "encoding: raw\n\n" + frame(other, 0));
  EXPECT_NE(refusal({first, second, small}).find("c.nrrd: it has 10 x 16 x 6 voxels"),
            std::string::npos);

  other = object_;
  other.grid.mm_from_index.translation().x() += 0.1;
  const fs::path moved =
      write("d.nrrd", nrrd_header(other.grid, 1) + "encoding: raw\n\n" + frame(other, 0));
  EXPECT_NE(refusal({first, moved}).find("d.nrrd: it lies elsewhere"), std::string::npos);

  EXPECT_NE(refusal({first, sequence("")}).find("a.seq.nrrd: it is 4-D"), std::string::npos);

  const fs::path empty = write("e.nrrd", nrrd_header(object_.grid, 1) + "encoding: raw\n\n" +
                                             std::string(object_.grid.count() * 2, '\0'));
  EXPECT_NE(refusal({first, empty}, {.rr_interval_s = 1}).find("phase 2 of 2 shows nothing"),
            std::string::npos);
  EXPECT_NE(refusal({first, second}, {.rr_interval_s = 1, .series = {3}}).find("among DICOM"),
            std::string::npos);
}

}  // namespace
}  // namespace beatlas::ingest
