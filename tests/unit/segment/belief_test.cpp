#include "pipeline/segment/belief.h"

#include <cmath>

#include <gtest/gtest.h>

#include "pipeline/prior/slices.h"
#include "runtime/atlas/structures.h"
#include "tests/unit/segment/made_images.h"

namespace beatlas::segment {
namespace {

/// Slices of 4 x 4 pixels of 2 mm, 10 mm apart. The prior says LV blood with .75 in the left half
/// of every slice and with .25 in the right one, and muscle for the rest.
struct Made {
  Grid stack = made::straight_grid({4, 4, 3}, {2, 2, 10});
  prior::PriorCycle prior;
  Box box;
  ImageCycle<std::uint8_t> labels;

  Made() {
    prior.grid = prior::network_grid(stack, 2, 1);
    prior.labels = {kLabelBackground, kLabelRvBlood, kLabelLvMyocardium, kLabelLvBlood};
    const std::size_t count = prior.grid.count();
    std::vector<std::int8_t>& phase = prior.phases.emplace_back(4 * count, std::int8_t{-128});
    for (std::size_t v = 0; v < count; ++v) {
      const double blood = v % 4 < 2 ? 0.75 : 0.25;
      phase[2 * count + v] = static_cast<std::int8_t>(std::lround(16 * std::log(1 - blood)));
      phase[3 * count + v] = static_cast<std::int8_t>(std::lround(16 * std::log(blood)));
    }
    box.first = {0, 0, 1};
    box.size = {4, 4, 2};
    labels.grid = stack.part(box.first, box.size);
    labels.phases.assign(1, std::vector<std::uint8_t>(labels.grid.count(), kLabelLvMyocardium));
    for (std::size_t v = 0; v < 16; ++v) {
      if (v % 4 < 2) labels.phases[0][v] = kLabelLvBlood;
    }
  }

  [[nodiscard]] Belief believed(bool told_second) const {
    return belief_in(prior, labels, box, {{false, told_second}},
                     {kVentricular.begin(), kVentricular.end()});
  }
};

TEST(Belief, IsWhatThePriorGivesTheLabels) {
  const Belief belief = Made().believed(false);
  const std::vector<SliceBelief>& blood = belief.at(Structure::LvBlood)[0];
  ASSERT_EQ(blood.size(), 3U);
  EXPECT_EQ(blood[0].expected_mm2, 0);  // beyond the box
  // Eight pixels of 4 mm2 of either kind; stored logarithms are rounded to 1/16.
  EXPECT_NEAR(blood[1].labelled_mm2, 32, 1e-9);
  EXPECT_NEAR(blood[1].expected_mm2, 32, 1);
  EXPECT_NEAR(blood[1].agreed_mm2, 24, 1);
  EXPECT_EQ(blood[2].labelled_mm2, 0);
  EXPECT_NEAR(blood[2].expected_mm2, 32, 1);
  EXPECT_EQ(blood[2].agreed_mm2, 0);
  const SliceBelief& heart = belief.at(Structure::Heart)[0][1];
  EXPECT_NEAR(heart.labelled_mm2, 64, 1e-9);
  EXPECT_NEAR(heart.agreed_mm2, 64, 0.1);
}

TEST(Belief, IsSureOfWhatAPersonTold) {
  const Belief belief = Made().believed(true);
  const SliceBelief& blood = belief.at(Structure::LvBlood)[0][2];
  EXPECT_EQ(blood.expected_mm2, 0);
  const SliceBelief& muscle = belief.at(Structure::LvMyocardium)[0][2];
  EXPECT_NEAR(muscle.expected_mm2, 64, 1e-9);
  EXPECT_NEAR(muscle.agreed_mm2, 64, 1e-9);
}

TEST(Belief, IsSureOfSlicesThatWerePainted) {
  const Made made;
  Belief belief = made.believed(false);
  const SliceBelief kept = belief.at(Structure::LvBlood)[0][1];
  LabelCycle before{made.stack, {std::vector<std::uint8_t>(made.stack.count(), 0)}};
  LabelCycle after = before;
  after.phases[0][made.stack.offset(1, 1, 2)] = kLabelLvBlood;
  believe_painted(before, after, belief);
  EXPECT_EQ(belief.at(Structure::LvBlood)[0][1].expected_mm2, kept.expected_mm2);
  EXPECT_NEAR(belief.at(Structure::LvBlood)[0][2].expected_mm2, 4, 1e-9);
  EXPECT_NEAR(belief.at(Structure::LvBlood)[0][2].labelled_mm2, 4, 1e-9);
  EXPECT_NEAR(belief.at(Structure::LvMyocardium)[0][2].labelled_mm2, 0, 1e-9);
}

}  // namespace
}  // namespace beatlas::segment
