#include <algorithm>
#include <filesystem>
#include <iostream>

#include <gtest/gtest.h>

#include "tests/unit/ingest/made_exam.h"

namespace beatlas::ingest {
namespace {

using test::all;
using test::decided;

std::filesystem::path shared(const std::string& name) {
  return std::filesystem::path(BEATLAS_SHARED_DATA) / name;
}

#define SKIP_WITHOUT(name)                                                         \
  if (!std::filesystem::exists(shared(name))) {                                    \
    GTEST_SKIP() << "the real exam " << shared(name) << " is not on this machine"; \
  }

TEST(RealExam, CineExamGivesSixSlicesOf25PhasesAndFiveViews) {
  SKIP_WITHOUT("cine-exam");
  StageContext context;
  const Exam exam = read_exam({shared("cine-exam")}, {}, context);
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
  SKIP_WITHOUT("two-phase-ge");
  StageContext context;
  const Exam exam = read_exam({shared("two-phase-ge")}, {}, context);
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

}  // namespace
}  // namespace beatlas::ingest
