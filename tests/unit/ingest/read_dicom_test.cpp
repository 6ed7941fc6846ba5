#include <algorithm>
#include <chrono>

#include <gtest/gtest.h>

#include "pipeline/core/parallel.h"
#include "pipeline/formats/dicom_writer.h"
#include "tests/unit/ingest/made_exam.h"

namespace beatlas::ingest {
namespace {

using test::all;
using test::decided;
using test::kRounding;
using test::MadeExam;

TEST(ReadDicom, MixedExamGivesTheCineStackWhereItLies) {
  const MadeExam made("mixed");
  const Exam exam = made.read();
  const Grid& grid = exam.stack.grid();
  EXPECT_EQ(exam.source_format, "dicom");
  EXPECT_EQ(grid.size, (Index3{96, 80, 24})) << all(exam);
  EXPECT_EQ(exam.stack.phase_count(), 10);
  EXPECT_TRUE(grid.mm_from_index.isApprox(made.lps_from_index(), 1e-8));
  EXPECT_GT(grid.mm_from_index.linear().determinant(), 0);
  EXPECT_LE(made.worst_error(exam.stack), kRounding);
  EXPECT_NEAR(exam.stack.rr_interval_s, 0.9, 1e-9);
  ASSERT_EQ(exam.stack.frame_times_s.size(), 10U);
  EXPECT_NEAR(exam.stack.frame_times_s[3], 0.27, 1e-9);
}

TEST(ReadDicom, CentroidsOfThreeUnequalSpheresAreRightInLps) {
  const MadeExam made("mixed");
  const Exam exam = made.read();
  const Grid& grid = exam.stack.grid();
  for (const auto& blob : made.truth()["blobs"]) {
    const auto c = blob["lps"].get<std::vector<double>>();
    const Vec3 centre(c[0], c[1], c[2]);
    const double reach = 5 * blob["sigma"].get<double>();
    Vec3 sum = Vec3::Zero();
    double weight = 0;
    for (int k = 0; k < grid.size[2]; ++k) {
      for (int j = 0; j < grid.size[1]; ++j) {
        for (int i = 0; i < grid.size[0]; ++i) {
          const Vec3 place = grid.mm(i, j, k);
          if ((place - centre).norm() > reach) continue;
          const double value = exam.stack.images.phases[0][grid.offset(i, j, k)] - 130.0;
          sum += value * place;
          weight += value;
        }
      }
    }
    EXPECT_LT((sum / weight - centre).norm(), 0.01) << "mm";
  }
}

TEST(ReadDicom, ViewsAreKeptAndTheRestIsToldWithoutPatientText) {
  const MadeExam made("mixed");
  const Exam exam = made.read();
  ASSERT_EQ(exam.views.size(), 2U) << all(exam);
  for (const Cine& view : exam.views) {
    EXPECT_EQ(view.grid().size, (Index3{14, 12, 1}));
    EXPECT_EQ(view.phase_count(), 10);
    EXPECT_NEAR(view.rr_interval_s, 0.8, 1e-9);
    EXPECT_TRUE(view.grid().spacing_mm().isApprox(Vec3(3, 2, 3), 1e-6));
  }
  EXPECT_EQ(exam.views[1].images.phases[4][2], 101.0F + 4 + 2);
  EXPECT_TRUE(decided(exam, "24 parallel slices of 10 phases, 5.00 mm apart")) << all(exam);
  EXPECT_TRUE(decided(exam, "ignored 1 that is no DICOM, ignored 1 empty file")) << all(exam);
  EXPECT_TRUE(decided(exam, "2 DICOM files without an image")) << all(exam);
  EXPECT_TRUE(decided(exam, "1 colour")) << all(exam);
  EXPECT_TRUE(decided(exam, "series 201, 202")) << all(exam);
  EXPECT_TRUE(decided(exam, "305")) << all(exam);
  EXPECT_TRUE(decided(exam, "Left: 43 images of slices")) << all(exam);
  EXPECT_FALSE(decided(exam, "SECRET")) << all(exam);
}

class SameExam : public testing::TestWithParam<const char*> {};

TEST_P(SameExam, ReadsAlikeHoweverItIsStored) {
  const MadeExam made(GetParam());
  const Exam exam = made.read();
  EXPECT_EQ(exam.stack.grid().size, (Index3{20, 16, 6})) << all(exam);
  EXPECT_EQ(exam.stack.phase_count(), 10);
  EXPECT_TRUE(exam.stack.grid().mm_from_index.isApprox(made.lps_from_index(), 1e-8));
  EXPECT_LE(made.worst_error(exam.stack), kRounding) << all(exam);
  EXPECT_NEAR(exam.stack.rr_interval_s, 0.9, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Forms, SameExam,
                         testing::Values("implicit", "rle", "one_series", "series_per_phase",
                                         "enhanced", "rescaled", "velocity", "copies",
                                         "constant_trigger", "no_trigger", "scan_time_trigger",
                                         "temporal_position", "parallel_stray"));

TEST(ReadDicom, SlicesWithTheirOwnBeatComeOutInPhase) {
  const MadeExam made("timing");
  const Exam exam = made.read();
  EXPECT_EQ(exam.stack.phase_count(), 25) << all(exam);
  // The cubic's error for 23 frames of a cosine of 30 % of 4000 is 0.06 %, that is 0.8 levels at
  // the brightest voxel; a slip of a tenth of a frame would be 30.
  EXPECT_LE(made.worst_error(exam.stack), 2.0);
  double mean = 0;
  for (const double rr : made.truth()["rr_ms"]) mean += rr / 6;
  EXPECT_NEAR(exam.stack.rr_interval_s, mean * 1e-3, 1e-6);
  EXPECT_TRUE(decided(exam, "resampled to common phases")) << all(exam);
}

TEST(ReadDicom, ProspectiveGatingKeepsItsPlaceInTheBeat) {
  const MadeExam made("prospective");
  const Exam exam = made.read();
  ASSERT_EQ(exam.stack.phase_count(), 22) << all(exam);
  // Nothing is known of the gap of 0.19 R-R before phase 0: the cubic bridges it within a ninth of
  // the beat's amplitude of 930 levels, a straight line would within a sixth. Frames taken as
  // uniform in the R-R interval would err by more than the amplitude.
  EXPECT_LE(made.worst_error(exam.stack), 930.0 / 9);
  EXPECT_NEAR(exam.stack.rr_interval_s, 0.9, 1e-9);
  EXPECT_NEAR(exam.stack.frame_times_s.back(), 0.85 * 0.9 * 21 / 22, 1e-6) << "as recorded";
}

TEST(ReadDicom, FallbacksInTimeAreTold) {
  EXPECT_TRUE(decided(MadeExam("constant_trigger").read(), "ordered by InstanceNumber"));
  EXPECT_TRUE(decided(MadeExam("scan_time_trigger").read(), "ordered by InstanceNumber"));
  EXPECT_TRUE(decided(MadeExam("temporal_position").read(), "ordered by TemporalPosition"));
}

TEST(ReadDicom, WithoutAnyRrItMustBeGiven) {
  const MadeExam made("no_rr");
  EXPECT_NE(made.refusal().find("give the R-R interval"), std::string::npos);
  const Exam exam = made.read({.rr_interval_s = 0.75});
  EXPECT_EQ(exam.stack.rr_interval_s, 0.75);
  EXPECT_LE(made.worst_error(exam.stack), kRounding);
}

TEST(ReadDicom, GivenRrAndPhasesAreUsed) {
  const MadeExam made("one_series");
  const Exam exam = made.read({.rr_interval_s = 1.25, .phases = 16});
  EXPECT_EQ(exam.stack.rr_interval_s, 1.25);
  EXPECT_EQ(exam.stack.phase_count(), 16);
  EXPECT_EQ(exam.stack.frame_times_s.size(), 10U) << "times as recorded";
  // 10 frames of a cosine: the cubic errs by 1 % of 30 % of 4000.
  EXPECT_LE(made.worst_error(exam.stack), 15.0);
}

TEST(ReadDicom, SkewedCosinesAreStraightenedAndTold) {
  const MadeExam made("skewed");
  const Exam exam = made.read();
  EXPECT_TRUE(decided(exam, "not quite orthonormal"));
  const Eigen::Matrix3d u = exam.stack.grid().mm_from_index.linear().colwise().normalized();
  EXPECT_TRUE((u.transpose() * u).isIdentity(1e-12));
  // Half the skew angle of 0.004 on each axis.
  EXPECT_LT((u - made.lps_from_index().linear().colwise().normalized()).cwiseAbs().maxCoeff(),
            0.004);
}

TEST(ReadDicom, LaterOfTwoEqualSeriesIsTaken) {
  const MadeExam made("repeated");
  const Exam exam = made.read();
  EXPECT_EQ(exam.stack.grid().size[2], 6);
  EXPECT_NEAR(exam.stack.images.phases[0][0], 130 + 500, 1.0);
  EXPECT_TRUE(decided(exam, "(series 50-55)"));
  EXPECT_TRUE(decided(exam, "another cine of the same place"));
}

TEST(ReadDicom, CopiesOfAnImageCountOnce) {
  EXPECT_TRUE(decided(MadeExam("copies").read(), "60 copies"));
}

TEST(ReadDicom, OneMissingFrameIsBridgedByItsNeighbours) {
  const MadeExam made("frame_missing");
  const Exam exam = made.read();
  EXPECT_EQ(exam.stack.grid().size[2], 6) << all(exam);
  EXPECT_EQ(exam.stack.phase_count(), 25);
  EXPECT_LE(made.worst_error(exam.stack), 5.0);  // a gap of 2/25, cubic: 0.5 % of the amplitude
  EXPECT_TRUE(decided(exam, "(series 3): fewer frames than other slices have")) << all(exam);
}

TEST(ReadDicom, IncompleteSliceAtTheEndIsLeftAndTold) {
  const MadeExam made("end_slice_incomplete");
  const Exam exam = made.read();
  EXPECT_EQ(exam.stack.grid().size[2], 5);
  EXPECT_LE(made.worst_error(exam.stack), kRounding);
  EXPECT_TRUE(decided(exam, "Warning: 1 slice lacks a part of the cycle")) << all(exam);
}

TEST(ReadDicom, AMissingSliceIsLeftBlankAndTold) {
  for (const char* which : {"middle_slice_incomplete", "middle_slice_missing"}) {
    const MadeExam made(which);
    const Exam exam = made.read();
    ASSERT_EQ(exam.stack.grid().size[2], 6) << which;
    EXPECT_TRUE(decided(exam, "Warning: slice 3 is missing within the stack and was left blank"))
        << all(exam);
    const std::size_t count = exam.stack.grid().slice_count();
    for (const std::vector<float>& phase : exam.stack.images.phases) {
      const auto at = phase.begin() + static_cast<std::ptrdiff_t>(3 * count);
      EXPECT_TRUE(std::all_of(at, at + static_cast<std::ptrdiff_t>(count),
                              [](float value) { return value == 0; }));
    }
    EXPECT_LE(made.worst_error(exam.stack, 3), kRounding) << "the others lie where they are";
  }
}

TEST(ReadDicom, SlicesThatStopEarlyAreBridgedAndTold) {
  for (const char* which : {"middle_slice_stops_early", "end_slice_stops_early"}) {
    const Exam exam = MadeExam(which).read();
    EXPECT_EQ(exam.stack.grid().size[2], 6) << which;
    EXPECT_EQ(exam.stack.images.phase_count(), 10) << which;
    EXPECT_TRUE(decided(exam, "Warning: 20 % of the cycle was never imaged")) << all(exam);
  }
}

TEST(ReadDicom, SlightlyUnevenSlicesAreTold) {
  const MadeExam made("slightly_uneven");
  const Exam exam = made.read();
  EXPECT_TRUE(decided(exam, "Warning: the gaps between slices differ")) << all(exam);
  // Gaps 8.3, 7.5, 8.3, 7.9, 8.2.
  EXPECT_NEAR(exam.stack.grid().spacing_mm()[2], 8.2, 1e-6);
  const Vec3 axis = made.lps_from_index().linear().col(2).normalized();
  for (int k = 0; k < 6; ++k) {
    const double along =
        axis.dot(exam.stack.grid().mm(0, 0, k) - Vec3(made.lps_from_index().translation()));
    EXPECT_NEAR(along, made.truth()["along_mm"][static_cast<std::size_t>(k)].get<double>(), 0.8);
  }
}

TEST(ReadDicom, StrayParallelSliceIsLeftAndTold) {
  EXPECT_TRUE(decided(MadeExam("parallel_stray").read(), "1 parallel slice does not continue"));
  EXPECT_EQ(MadeExam("hardly_sheared").read().stack.grid().size[2], 6);
}

TEST(ReadDicom, SlicesOfAFieldOfViewOfTheirOwnAreSeenOnThePixelsOfTheStack) {
  const MadeExam made("fields_of_view");
  const Exam exam = made.read();
  ASSERT_EQ(exam.stack.grid().size, (Index3{96, 80, 12})) << all(exam);
  EXPECT_TRUE(
      exam.stack.grid().mm_from_index.matrix().isApprox(made.lps_from_index().matrix(), 1e-6));
  // The sharpest ball has a sigma of two pixels and a height of 3900: the third derivative that
  // cubic convolution leaves out is worth 2 % of it.
  EXPECT_LE(made.worst_error(exam.stack), 0.02 * 3900);
  EXPECT_TRUE(decided(exam, "Warning: 2 slices have a field of view of their own")) << all(exam);
  EXPECT_TRUE(decided(exam, "resampled to the pixels of the stack (series 4, 12)")) << all(exam);
}

TEST(ReadDicom, AStackThatSlidesSidewaysIsStraightenedAndTold) {
  const Exam exam = MadeExam("sheared").read();
  EXPECT_EQ(exam.stack.grid().size, (Index3{20, 16, 6}));
  EXPECT_TRUE(decided(exam, "Warning: 5 slices have a field of view of their own")) << all(exam);
}

TEST(ReadDicom, ResultDoesNotDependOnThreads) {
  const MadeExam made("timing");
  set_thread_count(1);
  const Exam one = made.read();
  set_thread_count(4);
  const Exam four = made.read();
  set_thread_count(0);
  EXPECT_EQ(one.stack.images.phases, four.stack.images.phases);
  EXPECT_EQ(one.decisions, four.decisions);
}

TEST(ReadDicom, WhatWeWriteWeReadBackExactly) {
  const MadeExam made("timing");
  Cine cine = made.read().stack;
  for (auto& phase : cine.images.phases) {
    for (float& value : phase) value = std::round(value);
  }
  const beatlas::test::Folder folder;
  for (const std::string form : {"per_slice", "one", "enhanced"}) {
    const auto path = folder / form;
    if (form == "enhanced") {
      formats::write_enhanced_dicom(path, cine);
    } else {
      formats::write_dicom(path, cine, {.series_per_slice = form == "per_slice"});
    }
    StageContext context;
    const Exam back = read_exam({path}, {}, context);
    EXPECT_EQ(back.stack.images.phases, cine.images.phases);
    EXPECT_TRUE(back.stack.grid().mm_from_index.isApprox(cine.grid().mm_from_index, 1e-10));
    EXPECT_NEAR(back.stack.rr_interval_s, cine.rr_interval_s, 1e-9);
  }
}

TEST(ReadDicom, CancelStops) {
  const MadeExam made("one_series");
  const std::atomic<bool> cancel{true};
  StageContext context;
  context.cancel = &cancel;
  EXPECT_THROW((void)read_exam({made.path()}, {}, context), Error);
}

}  // namespace
}  // namespace beatlas::ingest
