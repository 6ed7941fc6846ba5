#include "pipeline/prior/tone.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include <gtest/gtest.h>

#include "pipeline/prior/stored.h"
#include "runtime/atlas/structures.h"
#include "tests/unit/prior/made_models.h"

namespace beatlas::prior {
namespace {

/// Two voxels in a row, in each of which these are the probabilities of background, RV blood, LV
/// muscle and LV blood.
PriorCycle two_voxels(const std::array<std::array<float, 4>, 2>& likely) {
  PriorCycle out;
  out.grid.size = {2, 1, 1};
  out.labels = {kLabelBackground, kLabelRvBlood, kLabelLvMyocardium, kLabelLvBlood};
  out.phases.resize(2);  // the second was not looked at
  for (std::size_t o = 0; o < 4; ++o) {
    for (const auto& voxel : likely) out.phases[0].push_back(stored_log(voxel[o]));
  }
  return out;
}

const Window kBoth{{0, 0, 0}, {2, 1, 1}};

TEST(ExpectedDice, IsThatOfWhatIsLikeliest) {
  // LV blood is likeliest in one voxel, where it is at .8, and at .3 in the other: 2 x .8 / (1
  // + 1.1).
  const PriorCycle prior = two_voxels({{{0.1F, 0.05F, 0.05F, 0.8F}, {0.6F, 0.05F, 0.05F, 0.3F}}});
  EXPECT_NEAR(expected_dice(prior, kBoth), 2 * 0.8 / 2.1 / 3, 0.01);
  EXPECT_EQ(expected_dice(prior, {{1, 0, 0}, {1, 1, 1}}), 0);  // background is no structure
}

TEST(ExpectedDice, OfWhatIsKnownIsOneForEachStructure) {
  EXPECT_NEAR(expected_dice(two_voxels({{{0, 0, 1, 0}, {0, 0, 0, 1}}}), kBoth), 2.0 / 3, 0.01);
}

PriorCycle prior_in(const nlohmann::json& tones, const Exam& exam) {
  const made::Folder folder;
  const Model model = Model::load(
      folder.copy_of("pixelwise", {}, [&](nlohmann::json& card) { card["tones"] = tones; }));
  StageContext context;
  return heart_prior(exam, model, context);
}

/// Most that a probability of the cycle is off the mean of two others'.
double most_off_mean(const PriorCycle& found, const PriorCycle& one, const PriorCycle& other) {
  const auto likely = [](std::int8_t stored) { return std::exp(stored / 16.0); };
  double most = 0;
  for (std::size_t p = 0; p < found.phases.size(); ++p) {
    for (std::size_t v = 0; v < found.phases[p].size(); ++v) {
      const double mean = 0.5 * (likely(one.phases[p][v]) + likely(other.phases[p][v]));
      most = std::max(most, std::abs(likely(found.phases[p][v]) - mean));
    }
  }
  return most;
}

TEST(Tones, AnExamIsShownInTheUsualOneAndInThatWhichIsSurer) {
  const Exam exam = made::rough_exam(made::turned_grid({24, 20, 4}, {2, 2, 8}), 3);
  const PriorCycle darker = prior_in({2}, exam);
  const PriorCycle brighter = prior_in({0.3}, exam);
  const Window all{{0, 0, 0}, exam.stack.grid().size};
  const double gain = expected_dice(brighter, all) - expected_dice(darker, all);
  ASSERT_GT(std::abs(gain), 0.03);
  const bool brighter_is_surer = gain > 0;
  EXPECT_EQ(prior_in(brighter_is_surer ? nlohmann::json({0.3, 2}) : nlohmann::json({2, 0.3}), exam)
                .phases,
            (brighter_is_surer ? brighter : darker).phases);
  const PriorCycle both =
      prior_in(brighter_is_surer ? nlohmann::json({2, 0.3}) : nlohmann::json({0.3, 2}), exam);
  constexpr double kRounded = 2.0 / 32;  // of 1 at most: found and both of the mean, to 1/32 each
  EXPECT_LE(most_off_mean(both, darker, brighter), kRounded);
  EXPECT_GT(most_off_mean(both, darker, darker), kRounded);
  EXPECT_GT(most_off_mean(both, brighter, brighter), kRounded);
}

}  // namespace
}  // namespace beatlas::prior
