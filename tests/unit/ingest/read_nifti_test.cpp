#include <gtest/gtest.h>

#include "tests/unit/ingest/made_exam.h"

namespace beatlas::ingest {
namespace {

using test::decided;
using test::kRounding;
using test::MadeExam;

TEST(ReadNifti, FourDimensionalFileIsTheStackWhereItLies) {
  const MadeExam made("nifti");
  const Exam exam = made.read();
  EXPECT_EQ(exam.source_format, "nifti");
  EXPECT_EQ(exam.stack.grid().size, (Index3{48, 40, 24}));
  EXPECT_EQ(exam.stack.phase_count(), 10);
  // The header keeps geometry as float32.
  EXPECT_TRUE(exam.stack.grid().mm_from_index.isApprox(made.lps_from_index(), 1e-6));
  EXPECT_LE(made.worst_error(exam.stack), kRounding);
  EXPECT_NEAR(exam.stack.rr_interval_s, 0.9, 1e-6);
  EXPECT_NEAR(exam.stack.frame_times_s.at(4), 0.36, 1e-6);
  EXPECT_TRUE(exam.views.empty());
}

TEST(ReadNifti, MillisecondsAreUnderstoodHoweverTheyAreMarked) {
  EXPECT_NEAR(MadeExam("nifti_ms").read().stack.rr_interval_s, 0.9, 1e-6);
  const Exam exam = MadeExam("nifti_ms_as_s").read();
  EXPECT_NEAR(exam.stack.rr_interval_s, 0.9, 1e-6);
  EXPECT_TRUE(decided(exam, "milliseconds"));
}

TEST(ReadNifti, TimeThatIsMissingMustBeGiven) {
  for (const char* variant : {"nifti_no_unit", "nifti_long"}) {
    const MadeExam made(variant);
    EXPECT_NE(made.refusal().find("give the R-R interval"), std::string::npos);
    EXPECT_EQ(made.read({.rr_interval_s = 0.8}).stack.rr_interval_s, 0.8);
  }
}

TEST(ReadNifti, GivenPhasesAreResampledTo) {
  const MadeExam made("nifti");
  const Exam exam = made.read({.phases = 20});
  EXPECT_EQ(exam.stack.phase_count(), 20);
  EXPECT_LE(made.worst_error(exam.stack), 15.0);  // 10 frames of a cosine by the cubic: 1 %
}

TEST(ReadNifti, FilesThatAreNoCineAreRefused) {
  EXPECT_NE(MadeExam("nifti_one_image").refusal().find("one image only"), std::string::npos);
  EXPECT_NE(MadeExam("nifti_two_slices").refusal().find("at least 3"), std::string::npos);
  EXPECT_NE(MadeExam("nifti_zero_phase").refusal().find("phase 4 of 10 shows nothing"),
            std::string::npos);
}

}  // namespace
}  // namespace beatlas::ingest
