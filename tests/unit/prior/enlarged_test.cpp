#include "pipeline/prior/enlarged.h"

#include <cmath>

#include <gtest/gtest.h>

#include "pipeline/prior/window.h"
#include "runtime/atlas/structures.h"
#include "tests/unit/prior/made_models.h"

namespace beatlas::prior {
namespace {

/// Cubes of LV blood in background, as two phases of three were seen; voxels of 2 x 2 x 2.5 mm.
PriorCycle seen(int edge, int edge_later, int edge_beside) {
  PriorCycle out;
  out.grid.size = {40, 40, 20};
  out.grid.mm_from_index.linear() = Vec3(2, 2, 2.5).asDiagonal();
  out.labels = {kLabelBackground, kLabelLvBlood};
  out.phases.resize(3);
  const auto fill = [&](std::size_t phase, int voxels, int first) {
    out.phases[phase].resize(2 * out.grid.count(), -32);
    for (int k = 0; k < voxels; ++k) {
      for (int j = 0; j < voxels; ++j) {
        for (int i = 0; i < voxels; ++i) {
          out.phases[phase][out.grid.count() + out.grid.offset(first + i, first + j, k)] = -2;
        }
      }
    }
  };
  fill(0, edge, 2);
  fill(2, edge_later, 2);
  fill(2, edge_beside, 25);
  return out;
}

TEST(Enlarged, AHeartSmallerThanAnyThatIsKnownIsShownAsLargeAsThoseInTheMiddle) {
  const PriorCycle prior = seen(8, 10, 6);  // 5.1 ml, 10 ml, and 2.2 ml apart from it
  EXPECT_NEAR(least_lv_ml(prior), 10, 1e-9);
  ModelCard card;
  Grid stack;
  stack.mm_from_index.linear() = Vec3(0.5, 0.8, 10).asDiagonal();
  EXPECT_EQ(enlargement(prior, stack, card), 1);  // a model that does not say
  card.lv_ml = {20, 80};
  EXPECT_NEAR(enlargement(prior, stack, card), std::cbrt(4), 1e-9);
  card.lv_ml = {10, 80};
  EXPECT_EQ(enlargement(prior, stack, card), 1);
  EXPECT_EQ(enlargement(seen(0, 0, 0), stack, card), 1);  // none was seen
}

TEST(Enlarged, AHeartOfWhichASliceIsSeenIsNoSmallerThanABallOfThatWidth) {
  PriorCycle prior = seen(8, 10, 6);
  // Two slices of 30 x 30 mm: 4.5 ml were seen of an LV that has more than 20.
  for (std::int8_t& log : prior.phases[2]) log = -32;
  for (int k = 0; k < 2; ++k) {
    for (int j = 5; j < 20; ++j) {
      for (int i = 5; i < 20; ++i) {
        prior.phases[2][prior.grid.count() + prior.grid.offset(i, j, k)] = -2;
      }
    }
  }
  const double radius_mm = 30 / std::sqrt(EIGEN_PI);
  EXPECT_NEAR(least_lv_ml(prior), 4.0 / 3 * EIGEN_PI * std::pow(radius_mm, 3) / 1000, 1e-9);
}

TEST(Enlarged, ImagesAreShownNoFinerThanTheyAre) {
  const PriorCycle prior = seen(8, 10, 6);
  ModelCard card;
  card.lv_ml = {400, 400};
  Grid stack;
  stack.mm_from_index.linear() = Vec3(0.5, 1.6, 10).asDiagonal();
  EXPECT_NEAR(enlargement(prior, stack, card), 2 / 1.6, 1e-9);
  stack.mm_from_index.linear() = Vec3(2.5, 2.5, 10).asDiagonal();
  EXPECT_EQ(enlargement(prior, stack, card), 1);
}

TEST(Enlarged, ThePriorOfASmallHeartIsThatOfALargerOneInItsOwnPlace) {
  const made::Folder folder;
  const auto with_least = [&](double ml) {
    return Model::load(folder.copy_of("frame_alone", {}, [&](nlohmann::json& card) {
      // What is bright is its third output.
      card["outputs"] = {"background", "rv_blood", "lv_blood", "lv_myocardium"};
      card["lv_ml"] = {ml, ml};
    }));
  };
  const Exam exam = made::rough_exam(made::turned_grid({60, 52, 4}, {0.9, 0.9, 6}), 3);
  StageContext context;
  const PriorCycle plain = heart_prior(exam, with_least(0), context);
  const PriorCycle small = heart_prior(exam, with_least(500), context);
  const double times = plain.grid.spacing_mm()[0] / small.grid.spacing_mm()[0];
  EXPECT_GT(times, 1.5);
  EXPECT_NEAR(small.grid.spacing_mm()[2], plain.grid.spacing_mm()[2], 1e-9);
  const PriorCycle larger = heart_prior(enlarged(exam, times), with_least(0), context);
  EXPECT_EQ(small.grid.size, larger.grid.size);
  EXPECT_EQ(small.phases, larger.phases);
  const Vec3 end(small.grid.size[0] - 1, small.grid.size[1] - 1, small.grid.size[2] - 1);
  EXPECT_LT((times * (small.grid.mm_from_index * end) - larger.grid.mm_from_index * end).norm(),
            1e-9);
}

}  // namespace
}  // namespace beatlas::prior
