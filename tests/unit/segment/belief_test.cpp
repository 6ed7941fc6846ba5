#include "pipeline/segment/belief.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "pipeline/prior/slices.h"
#include "runtime/atlas/structures.h"
#include "tests/made_images.h"

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

  [[nodiscard]] Belief believed(const LabelImages& marks, const KnownLabels& known = {}) const {
    return belief_in(prior, labels, box, {.marks = marks, .known = known},
                     {kVentricular.begin(), kVentricular.end()});
  }
  [[nodiscard]] LabelImages unmarked() const {
    return {std::vector<std::uint8_t>(labels.grid.count(), kUnlabelled)};
  }
  /// One voxel of the box's second slice.
  [[nodiscard]] LabelImages marked(int i, std::uint8_t label) const {
    LabelImages marks = unmarked();
    marks[0][labels.grid.offset(i, 1, 1)] = label;
    return marks;
  }
};

TEST(Belief, IsWhatThePriorGivesTheLabels) {
  const Made made;
  const Belief belief = made.believed(made.unmarked());
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
  const Made made;
  // The prior says blood there.
  const Belief belief = made.believed(made.marked(0, kLabelLvMyocardium));
  const SliceBelief& blood = belief.at(Structure::LvBlood)[0][2];
  EXPECT_EQ(blood.expected_mm2, 0);
  const SliceBelief& muscle = belief.at(Structure::LvMyocardium)[0][2];
  EXPECT_NEAR(muscle.expected_mm2, 64, 1e-9);
  EXPECT_NEAR(muscle.agreed_mm2, 64, 1e-9);
}

TEST(Belief, IsNoSurerForAMarkOnWhatWasExpected) {
  const Made made;
  const Belief before = made.believed(made.unmarked());
  const Belief after = made.believed(made.marked(0, kLabelLvBlood));
  for (const Structure structure : kVentricular) {
    const SliceBelief& was = before.at(structure)[0][2];
    const SliceBelief& is = after.at(structure)[0][2];
    EXPECT_EQ(is.expected_mm2, was.expected_mm2);
    EXPECT_EQ(is.agreed_mm2, was.agreed_mm2);
  }
}

/// A phase's labels of the LV's blood alone: of the rest nobody said anything.
TEST(Belief, OfKnownLabelsIsSureOfWhatTheyTellAlone) {
  const Made made;
  KnownLabels known{{made.labels.grid, made.unmarked()}, {0}};
  std::vector<std::uint8_t>& image = known.labels.phases[0];
  std::fill(image.begin(), image.end(), kLabelBackground);
  for (std::size_t v = 0; v < 16; ++v) {
    if (v % 4 < 2) image[v] = kLabelLvBlood;
  }
  // Half of the second slice was left open.
  for (std::size_t v = 16; v < 24; ++v) image[v] = kLabelUnknown;
  const Belief before = made.believed(made.unmarked());
  const Belief belief = made.believed(made.unmarked(), known);
  const std::vector<SliceBelief>& blood = belief.at(Structure::LvBlood)[0];
  EXPECT_NEAR(blood[1].expected_mm2, 32, 1e-9);
  EXPECT_NEAR(blood[1].agreed_mm2, 32, 1e-9);
  EXPECT_NEAR(blood[2].expected_mm2, 0.5 * before.at(Structure::LvBlood)[0][2].expected_mm2, 0.1);
  // Where the blood is there is no wall; beside it the wall is as likely as it was.
  const SliceBelief& muscle = belief.at(Structure::LvMyocardium)[0][1];
  EXPECT_NEAR(muscle.expected_mm2, 24, 1);
  EXPECT_NEAR(belief.at(Structure::LvMyocardium)[0][2].expected_mm2,
              before.at(Structure::LvMyocardium)[0][2].expected_mm2, 0.1);
}

TEST(Belief, IsSureOfSlicesThatWerePainted) {
  const Made made;
  Belief belief = made.believed(made.unmarked());
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
