/// Exams of drawn hearts: their volumes, their limits, and that nothing but the seed makes them.

#include "pipeline/phantom/drawn_exam.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "pipeline/core/parallel.h"
#include "pipeline/phantom/family.h"
#include "runtime/atlas/structures.h"

namespace beatlas::phantom {
namespace {

constexpr DrawnExamOptions kFew{.most_voxels = 1100000};

DrawnExam draw(std::uint32_t seed) {
  StageContext context;
  return drawn_exam(seed, kFew, context);
}

double curve_end(const nlohmann::json& truth, const std::string& name, bool most) {
  for (const nlohmann::json& structure : truth["structures"]) {
    if (structure["name"] != name) continue;
    const auto curve = structure["volume_ml"].get<std::vector<double>>();
    return most ? *std::max_element(curve.begin(), curve.end())
                : *std::min_element(curve.begin(), curve.end());
  }
  return -1;
}

TEST(Family, DrawsWhatIsUsualWhereItIsAskedTo) {
  int unlike = 0;
  for (std::uint32_t seed = 0; seed < 200; ++seed) {
    const Family whole(seed, Purpose::Training);
    const Family usual(seed, Purpose::Training, Ranges::Usual);
    EXPECT_GE(usual.number("snr"), 20);
    EXPECT_LE(usual.number("snr"), 60);
    EXPECT_FALSE(usual.happens("random_contrast"));
    EXPECT_EQ(whole.number("fat_pad"), 0);
    EXPECT_EQ(whole.number("lv_edv"), usual.number("lv_edv"))
        << "no row of that says what is usual";
    EXPECT_EQ(Family(seed, Purpose::Judging).ranges(), Ranges::Whole);
    unlike += whole.number("snr") != usual.number("snr") ? 1 : 0;
  }
  EXPECT_GT(unlike, 190);
}

TEST(DrawnExam, VolumesAreWithinTheirStatedErrorOfAFinerLattice) {
  for (const std::uint32_t seed : {7U, 8U}) {
    const DrawnHeart heart(Family(seed, Purpose::Judging));
    for (const float contraction : {0.0F, 1.0F}) {
      const auto coarse = drawn_volumes_ml(heart, contraction, 4);
      const auto fine = drawn_volumes_ml(heart, contraction, 10);
      for (const std::size_t label : {kLabelLvBlood, kLabelLvMyocardium, kLabelRvBlood}) {
        EXPECT_NEAR(coarse[label], fine[label], 0.5) << "seed " << seed << " label " << label;
      }
    }
  }
}

TEST(DrawnExam, IsTheSameForAnyNumberOfThreads) {
  set_thread_count(1);
  const DrawnExam one = draw(10000);
  set_thread_count(3);
  const DrawnExam three = draw(10000);
  set_thread_count(0);
  EXPECT_EQ(one.cine.images.phases, three.cine.images.phases);
  EXPECT_EQ(one.labels.phases, three.labels.phases);
  EXPECT_EQ(one.source_labels.phases, three.source_labels.phases);
  EXPECT_EQ(one.truth, three.truth);
}

TEST(DrawnExam, StaysWithinTheLimitsOfTheFamily) {
  for (const std::uint32_t seed : {0U, 10000U, 10010U, 99999999U}) {
    const DrawnExam exam = draw(seed);
    const nlohmann::json& truth = exam.truth;
    EXPECT_LE(exam.cine.grid().count() * exam.cine.images.phases.size(), 1100000U);
    EXPECT_EQ(truth["purpose"], seed < kFirstJudgingSeed ? "training" : "judging");
    if (seed < kFirstJudgingSeed) {
      EXPECT_EQ(truth["rendering"], "box");
    }
    if (!truth["has_heart"]) {
      EXPECT_EQ(curve_end(truth, "heart", true), 0);
      continue;
    }
    EXPECT_TRUE(Family::in_range("exam_lv_edv", truth["measured"]["lv_edv"]));
    EXPECT_TRUE(Family::in_range("exam_lv_ef", truth["measured"]["lv_ef"]));
    EXPECT_TRUE(Family::in_range("exam_wall", truth["measured"]["wall"]));
    // Frames lie within the beat that was measured at its ends.
    EXPECT_LE(curve_end(truth, "lv_blood", true), truth["measured"]["lv_edv"].get<double>() + 0.2);
    // The labels hold what the body has in view, to the roughness of their voxels.
    const auto& first = exam.labels.phases.front();
    const double in_labels =
        static_cast<double>(std::count(first.begin(), first.end(), kLabelLvBlood)) *
        exam.cine.grid().voxel_ml();
    double full = 0;
    for (const nlohmann::json& s : truth["structures"]) {
      if (s["name"] == "lv_blood") full = s["volume_ml"][0];
    }
    EXPECT_NEAR(in_labels, full * truth["measured"]["in_view"].get<double>(), 0.08 * full + 2)
        << "seed " << seed;
  }
}

TEST(DrawnExam, HasViewsAlongTheVentricleThatChangeNothingOfItsStack) {
  constexpr std::uint32_t kAcross = 10004;  // a short-axis stack
  StageContext context;
  const DrawnExam without = draw(kAcross);
  ASSERT_EQ(without.truth["stack"]["plane"], "short_axis");
  const DrawnExam with = drawn_exam(kAcross, {.most_voxels = 1100000, .views = 2}, context);
  EXPECT_EQ(with.cine.images.phases, without.cine.images.phases);
  EXPECT_EQ(with.identity, without.identity);
  ASSERT_EQ(with.views.size(), 2U);
  const auto normal = [](const Cine& cine) -> Vec3 {
    return cine.grid().mm_from_index.linear().col(2).normalized();
  };
  const double degrees_30 = std::sqrt(0.75);
  for (const Cine& view : with.views) {
    EXPECT_EQ(view.grid().size[2], 1);
    EXPECT_EQ(view.phase_count(), with.cine.phase_count());
    EXPECT_EQ(view.rr_interval_s, with.cine.rr_interval_s);
    // Along the LV, whose axis the stack's normal is but for its tilt.
    EXPECT_LT(std::abs(normal(view).dot(normal(with.cine))), 0.5);
    EXPECT_NE(view.images.phases.front(), view.images.phases[view.images.phases.size() / 2]);
  }
  EXPECT_LT(std::abs(normal(with.views[0]).dot(normal(with.views[1]))), 1 - degrees_30);
}

}  // namespace
}  // namespace beatlas::phantom
