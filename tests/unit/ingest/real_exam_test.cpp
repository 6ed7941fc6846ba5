#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/real_exams.h"
#include "tests/unit/ingest/made_exam.h"

namespace beatlas::ingest {
namespace {

using beatlas::test::real_exam;
using test::all;
using test::decided;

TEST(RealExam, CineExamGivesSixSlicesOf25PhasesAndFiveViews) {
  BEATLAS_NEEDS_REAL_EXAM("cine-exam");
  StageContext context;
  const Exam exam = read_exam({real_exam("cine-exam")}, {}, context);
  const Grid& grid = exam.stack.grid();
  EXPECT_EQ(grid.size, (Index3{256, 208, 6})) << all(exam);
  EXPECT_EQ(exam.stack.phase_count(), 25);
  EXPECT_TRUE(grid.spacing_mm().isApprox(Vec3(1.40625, 1.40625, 17.70), 1e-3))
      << grid.spacing_mm().transpose();
  EXPECT_NEAR(exam.stack.rr_interval_s, (863 + 860 + 829 + 776 + 814 + 831) / 6e3, 1e-5);
  // Row x column points from apex to base here: series 5 first, series 11 last.
  EXPECT_LT((grid.mm(0, 0, 0) - Vec3(-159.772, -134.36, -125.574)).norm(), 0.01);
  EXPECT_LT((grid.mm(0, 0, 5) - Vec3(-202.214, -79.6032, -70.5046)).norm(), 0.01);
  EXPECT_EQ(exam.views.size(), 5U);
  for (const Cine& view : exam.views) {
    EXPECT_EQ(view.grid().size[2], 1);
    EXPECT_EQ(view.phase_count(), 25);
    EXPECT_GT(*std::max_element(view.images.phases[7].begin(), view.images.phases[7].end()), 0);
  }
  EXPECT_EQ(exam.stack.frame_times_s.size(), 25U);
  EXPECT_FALSE(decided(exam, "SAMPLE")) << all(exam);
  std::cout << all(exam);
}

TEST(RealExam, TwoPhaseSeriesGivesItsFourCompletePositions) {
  BEATLAS_NEEDS_REAL_EXAM("two-phase-ge");
  StageContext context;
  const Exam exam = read_exam({real_exam("two-phase-ge")}, {}, context);
  EXPECT_EQ(exam.stack.grid().size, (Index3{256, 256, 4})) << all(exam);
  EXPECT_EQ(exam.stack.phase_count(), 2);
  EXPECT_NEAR(exam.stack.grid().spacing_mm()[2], 8.0, 0.01);
  EXPECT_NEAR(exam.stack.rr_interval_s, 0.967, 1e-9);
  EXPECT_EQ(exam.stack.frame_times_s, (std::vector<double>{0.348, 0.929}));
  EXPECT_TRUE(decided(exam, "Warning: 2 slices parallel to the stack have one phase only"))
      << all(exam);
  EXPECT_TRUE(decided(exam, "Too few frames a cycle to blend")) << all(exam);
  std::cout << all(exam);
}

/// Copies of the exam's images under names without meaning, in an order of their own.
class Copied {
 public:
  Copied() {
    std::vector<std::filesystem::path> files;
    for (const auto& entry :
         std::filesystem::recursive_directory_iterator(real_exam("cine-exam"))) {
      if (entry.is_regular_file() && entry.path().filename() != "LICENSE") {
        files.push_back(entry.path());
      }
    }
    std::sort(files.begin(), files.end());
    std::shuffle(files.begin(), files.end(), std::mt19937(3));  // NOLINT: the same every time
    for (const auto& file : files) add(file);
  }
  std::filesystem::path add(const std::filesystem::path& file) {
    std::string name = "x";
    for (int rest = count_++; rest > 0; rest /= 26) name += static_cast<char>('a' + rest % 26);
    std::filesystem::copy_file(file, folder_ / name);
    return folder_ / name;
  }
  /// Names and contents, for changes.
  [[nodiscard]] std::vector<std::filesystem::path> files() const {
    std::vector<std::filesystem::path> out;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
      out.push_back(entry.path());
    }
    std::sort(out.begin(), out.end());
    return out;
  }
  [[nodiscard]] Exam read(const IngestOptions& options = {}) const {
    StageContext context;
    return read_exam({folder_.path()}, options, context);
  }
  [[nodiscard]] std::string refusal(const IngestOptions& options = {}) const {
    try {
      (void)read(options);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
      return error.what();
    }
    return "was read";
  }

 private:
  beatlas::test::Folder folder_;
  int count_ = 0;
};

const Exam& undisturbed() {
  static const Exam exam = [] {
    StageContext context;
    return read_exam({real_exam("cine-exam")}, {}, context);
  }();
  return exam;
}

void expect_same(const Exam& exam) {
  EXPECT_EQ(exam.stack.images.phases, undisturbed().stack.images.phases) << all(exam);
  EXPECT_TRUE(exam.stack.grid() == undisturbed().stack.grid());
  EXPECT_EQ(exam.stack.frame_times_s, undisturbed().stack.frame_times_s);
  ASSERT_EQ(exam.views.size(), undisturbed().views.size());
  for (std::size_t v = 0; v < exam.views.size(); ++v) {
    EXPECT_EQ(exam.views[v].images.phases, undisturbed().views[v].images.phases);
  }
}

TEST(RealExam, NamesOrderAndCopiesDoNotMatter) {
  BEATLAS_NEEDS_REAL_EXAM("cine-exam");
  Copied copied;
  expect_same(copied.read());
  copied.add(copied.files()[17]);
  const Exam doubled = copied.read();
  expect_same(doubled);
  EXPECT_TRUE(decided(doubled, "ignored 1 copy")) << all(doubled);
}

TEST(RealExam, AFileCutShortIsNamed) {
  BEATLAS_NEEDS_REAL_EXAM("cine-exam");
  const Copied copied;
  const auto bad = copied.files()[40];
  std::filesystem::resize_file(bad, std::filesystem::file_size(bad) - 1000);
  const std::string message = copied.refusal();
  const std::string end =
      bad.filename().string() + ": the file is truncated or damaged; copy it again";
  EXPECT_NE(message.find(end), std::string::npos) << message;
}

TEST(RealExam, AMissingFileIsBridgedAndTold) {
  BEATLAS_NEEDS_REAL_EXAM("cine-exam");
  const Copied copied;
  // Whichever it is: of the stack it is bridged, of a view the view has fewer frames.
  std::filesystem::remove(copied.files()[40]);
  const Exam exam = copied.read();
  EXPECT_EQ(exam.stack.grid().size, undisturbed().stack.grid().size) << all(exam);
  EXPECT_EQ(exam.stack.phase_count(), 25);
  EXPECT_EQ(exam.views.size(), 5U);
  EXPECT_TRUE(decided(exam, "Read 274 images")) << all(exam);
}

TEST(RealExam, AForeignImageIsAQuestion) {
  BEATLAS_NEEDS_REAL_EXAM("cine-exam");
  BEATLAS_NEEDS_REAL_EXAM("two-phase-ge");
  Copied copied;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(real_exam("two-phase-ge/dicom"))) {
    if (!entry.is_regular_file()) continue;
    copied.add(entry.path());
    break;
  }
  const std::string message = copied.refusal();
  EXPECT_NE(message.find("choose one with --exam N: 1. 275 images of series"), std::string::npos)
      << message;
  EXPECT_NE(message.find("; 2. 1 image of series"), std::string::npos) << message;
  IngestOptions first;
  first.exam = 1;
  expect_same(copied.read(first));
}

TEST(RealExam, WithoutTriggerTimesTheOrderIsKept) {
  BEATLAS_NEEDS_REAL_EXAM("cine-exam");
  const Copied copied;
  for (const auto& file : copied.files()) {
    std::ifstream in(file, std::ios::binary);
    std::string content((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    const std::size_t at =
        content.find(std::string("\x18\0\x60\x10"
                                 "DS",
                                 6));
    ASSERT_NE(at, std::string::npos);
    const auto length = static_cast<std::size_t>(static_cast<unsigned char>(content[at + 6]));
    content.replace(at + 8, length, length, ' ');
    std::ofstream(file, std::ios::binary) << content;
  }
  const Exam exam = copied.read();
  EXPECT_TRUE(decided(exam, "not every image has a trigger time")) << all(exam);
  ASSERT_EQ(exam.stack.grid().size, undisturbed().stack.grid().size) << all(exam);
  ASSERT_EQ(exam.stack.phase_count(), 25);
  // Frames that were copied to their phases before lie at the same phases now, but for a cycle that
  // does not start with its first frame.
  int same = 0;
  for (std::size_t p = 0; p < 25; ++p) {
    same += exam.stack.images.phases[p] == undisturbed().stack.images.phases[p] ? 1 : 0;
  }
  EXPECT_GE(same, 20) << all(exam);
}

TEST(RealExam, OneSeriesIsNoStack) {
  BEATLAS_NEEDS_REAL_EXAM("cine-exam");
  StageContext context;
  IngestOptions options;
  options.series = {7001};
  try {
    (void)read_exam({real_exam("cine-exam")}, options, context);
    FAIL() << "was read";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("at most 1 parallel slice has several phases"),
              std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace beatlas::ingest
