/// What drawn seeds say of a ventricle's ends, and what is said of seeds that are not followed.
#include "pipeline/segment/drawn_ends.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <numbers>

#include <gtest/gtest.h>

#include "pipeline/segment/drawn_seeds.h"
#include "pipeline/segment/followed_seeds.h"
#include "pipeline/segment/segment.h"
#include "tests/unit/segment/imaged_phantom.h"
#include "tests/unit/segment/made_images.h"

namespace beatlas::segment {
namespace {

Chambers with_areas(const std::vector<double>& areas_mm2, int base_step) {
  Chambers out;
  out.base_step = base_step;
  for (const double area : areas_mm2) {
    LvSlice slice{static_cast<int>(out.lv.size()) + 2, {}, std::vector<Ring>(1)};
    slice.rings[0].area_mm2 = area;
    out.lv.push_back(slice);
  }
  return out;
}

TEST(DoubtedBase, is_the_third_that_is_clearly_narrower_than_the_other_end) {
  const std::vector<double> root_first{500, 1900, 1800, 1500, 1300, 1100, 900, 700, 600};
  EXPECT_EQ(doubted_base(with_areas(root_first, 1)), (std::vector<int>{8, 9, 10}));
  EXPECT_TRUE(doubted_base(with_areas(root_first, -1)).empty());
  const std::vector<double> root_last(root_first.rbegin(), root_first.rend());
  EXPECT_EQ(doubted_base(with_areas(root_last, -1)), (std::vector<int>{2, 3, 4}));
  EXPECT_TRUE(doubted_base(with_areas({1000, 1050, 1100, 1000, 950, 1000}, 1)).empty());
  EXPECT_TRUE(doubted_base(with_areas({1000}, 1)).empty());
}

TEST(DrawnReach, moves_planes_that_would_cut_off_a_drawn_slice_of_their_phase) {
  const Grid grid = made::straight_grid({4, 4, 10}, {2, 2, 10});
  LabelImages marks(3, std::vector<std::uint8_t>(grid.count(), kUnlabelled));
  marks[0][grid.offset(1, 1, 1)] = kLabelLvBlood;
  marks[1][grid.offset(1, 1, 2)] = kLabelLvMyocardium;
  marks[1][grid.offset(1, 1, 8)] = kLabelLvBlood;
  marks[1][grid.offset(2, 2, 3)] = kLabelRvBlood;
  const DrawnReach reach = drawn_reach(grid, marks, -1);
  EXPECT_EQ(reach.lv_base, (std::vector<int>{1, 2, -1}));
  EXPECT_EQ(reach.lv_apex, (std::vector<int>{1, 8, -1}));
  EXPECT_EQ(reach.rv_base, (std::vector<int>{-1, 3, -1}));
  VentricleEnds ends;
  ends.lv = {2.2, 1.7, 2.2};
  ends.lv_apex = {7.0, 7.0, 7.0};
  reach_drawn_slices(reach, -1, ends);
  EXPECT_EQ(*ends.lv, (std::vector<double>{0.5, 1.7, 2.2}));
  EXPECT_EQ(*ends.lv_apex, (std::vector<double>{7.0, 8.5, 7.0}));
  EXPECT_FALSE(ends.rv.has_value());
}

TEST(SeedsNotFollowed, are_told_with_place_and_reason) {
  const Grid grid = made::straight_grid({12, 12, 4}, {2, 2, 10});
  ImageCycle<std::uint8_t> labels{
      grid, LabelImages(2, std::vector<std::uint8_t>(grid.count(), kLabelRestOfHeart))};
  const std::vector<Seed> seeds{{kLabelLvBlood, grid.mm(3, 3, 0), 2.5, -1, {}},
                                {kLabelLvBlood, grid.mm(8, 8, 1), 2.5, 0, {}},
                                {kLabelRvBlood, grid.mm(3, 8, 2), 2.5, 1, {}},
                                {kLabelBackground, grid.mm(8, 3, 2), 2.5, -1, {}}};
  LabelImages marks(2, std::vector<std::uint8_t>(grid.count(), kUnlabelled));
  draw_seeds(grid, seeds, marks);
  // The first is lost, the second alone, the third well within its structure.
  for (std::size_t v = 0; v < grid.count(); ++v) {
    if (marks[0][v] == kLabelLvBlood && v >= grid.slice_count())
      labels.phases[0][v] = kLabelLvBlood;
  }
  std::fill(labels.phases[1].begin() + static_cast<std::ptrdiff_t>(grid.offset(0, 0, 2)),
            labels.phases[1].end(), kLabelRvBlood);
  const std::vector<std::string> told = seeds_not_followed(labels, seeds, marks);
  ASSERT_EQ(told.size(), 2U);
  EXPECT_NE(told[0].find("seed 1, lv_blood at (6, 6, 0) mm LPS, every phase, was not followed in 2 "
                         "phases: the ventricle was found to end before it"),
            std::string::npos)
      << told[0];
  EXPECT_NE(told[1].find("phase 0, stays alone: all about it is rest_of_heart"), std::string::npos)
      << told[1];
  std::vector<Seed> many(8, seeds[0]);
  EXPECT_EQ(seeds_not_followed(labels, many, marks).size(), 5U);
  EXPECT_NE(seeds_not_followed(labels, many, marks).back().find("3 more seeds"), std::string::npos);
}

/// Rings of muscle in lung, thick slices, no RV: below the first one, narrow as an aortic root, the
/// LV narrows to the last.
/// With the truth of every phase, in which the first slice is rest of heart.
struct Rings {
  static constexpr int kPhases = 6;
  Exam exam;
  LabelCycle truth;

  Rings() {
    const std::vector<double> radius_mm{9, 24, 24, 23, 21, 19, 17, 15, 12};
    const Grid grid = made::straight_grid({64, 64, 9}, {2, 2, 10});
    exam.stack.rr_interval_s = 0.9;
    exam.stack.images = made::constant_images(grid, kPhases, 10);
    truth = {grid, LabelImages(kPhases, std::vector<std::uint8_t>(grid.count(), 0))};
    for (std::size_t p = 0; p < kPhases; ++p) {
      exam.stack.frame_times_s.push_back(0.9 * static_cast<double>(p) / kPhases);
      const double beat =
          0.5 - 0.5 * std::cos(2 * std::numbers::pi * static_cast<double>(p) / kPhases);
      for (int k = 0; k < grid.size[2]; ++k) {
        const double open = radius_mm[static_cast<std::size_t>(k)];
        for (int j = 0; j < grid.size[1]; ++j) {
          for (int i = 0; i < grid.size[0]; ++i) {
            const double away = 2 * std::hypot(i - 32, j - 31);
            const bool blood = away < open * (1 - 0.3 * beat);
            if (!blood && away >= open + 10 - 3 * beat) continue;
            const std::size_t v = grid.offset(i, j, k);
            exam.stack.images.phases[p][v] = blood ? 300 : 100;
            truth.phases[p][v] = k == 0  ? kLabelRestOfHeart
                                 : blood ? kLabelLvBlood
                                         : kLabelLvMyocardium;
          }
        }
      }
    }
    made::add_rician_noise(exam.stack.images, 8, 3);
  }
};

TEST(DrawnEnds, labels_of_two_phases_tell_which_end_is_the_base_in_the_others) {
  const Rings made;
  StageContext context;
  const KnownLabels known{{made.truth.grid, {made.truth.phases[0], made.truth.phases[3]}}, {0, 3}};
  const Segmentation found = segment_exam(made.exam, {}, {}, context, known);
  EXPECT_EQ(found.base_cuts.at(Structure::LvBlood).base_step, -1);
  const auto worst = [&](std::uint8_t label) {
    double least = 1;
    for (const std::size_t p : {1, 2, 4, 5}) {
      least =
          std::min(least, made::dice(
                              made.truth.grid.count(),
                              [&](std::size_t v) { return made.truth.phases[p][v] == label; },
                              [&](std::size_t v) { return found.labels.phases[p][v] == label; }));
    }
    return least;
  };
  std::cout << "LV " << worst(kLabelLvBlood) << ", muscle " << worst(kLabelLvMyocardium) << "\n";
  EXPECT_GT(worst(kLabelLvBlood), 0.9);
}

TEST(DrawnEnds, seeds_in_what_was_taken_for_the_base_turn_the_ventricle_over) {
  const Rings made;
  const Exam& exam = made.exam;
  const Grid& grid = made.truth.grid;
  StageContext context;
  SolveMemory memory;
  (void)segment_exam(exam, {}, {}, context, {}, &memory);
  const std::vector<Seed> seeds{{kLabelLvBlood, grid.mm(32, 31, 7), 3, -1, {}}};
  const Segmentation drawn = segment_exam(exam, seeds, {}, context, {}, &memory);
  const BaseCut& cut = drawn.base_cuts.at(Structure::LvBlood);
  EXPECT_EQ(cut.base_step, -1);
  for (const std::vector<std::uint8_t>& phase : drawn.labels.phases) {
    for (int k = 1; k < 9; ++k) {
      EXPECT_EQ(phase[grid.offset(32, 31, k)], kLabelLvBlood) << "slice " << k;
    }
  }
  // What an earlier solve left, turned or not, changes nothing.
  EXPECT_EQ(segment_exam(exam, seeds, {}, context).labels.phases, drawn.labels.phases);
  const Segmentation back = segment_exam(exam, {}, {}, context, {}, &memory);
  EXPECT_EQ(segment_exam(exam, {}, {}, context).labels.phases, back.labels.phases);
}

TEST(DrawnEnds, a_slice_with_a_seed_of_lv_blood_is_the_lvs) {
  phantom::PhantomSpec spec = made::clinical_part();
  spec.phases = 6;
  const made::ImagedPhantom made(spec);
  StageContext context;
  const Segmentation plain = segment_exam(made.exam, {}, {}, context);
  const Grid& grid = plain.labels.grid;
  const BaseCut& cut = plain.base_cuts.at(Structure::LvBlood);
  // In systole the slice that the base has left shows the atrium; whoever draws LV there gets it.
  const auto es = static_cast<std::size_t>(plain.end_systole);
  const int k = static_cast<int>(std::floor(cut.k[es])) + 1;
  ASSERT_LT(k, grid.size[2]);
  const auto lv_of = [&](const Segmentation& result) {
    const auto from =
        result.labels.phases[es].begin() + static_cast<std::ptrdiff_t>(grid.offset(0, 0, k));
    return std::count(from, from + static_cast<std::ptrdiff_t>(grid.slice_count()), kLabelLvBlood);
  };
  EXPECT_EQ(lv_of(plain), 0);
  Vec3 middle = Vec3::Zero();
  double count = 0;
  for (int j = 0; j < grid.size[1]; ++j) {
    for (int i = 0; i < grid.size[0]; ++i) {
      if (plain.labels.phases[es][grid.offset(i, j, k - 1)] != kLabelLvBlood) continue;
      middle += grid.mm(i, j, k);
      count += 1;
    }
  }
  const std::vector<Seed> seeds{{kLabelLvBlood, middle / count, 3, plain.end_systole, {}}};
  const Segmentation drawn = segment_exam(made.exam, seeds, {}, context);
  // Half of the cavity in the slice below.
  EXPECT_GT(lv_of(drawn), 0.5 * count);
  for (const std::string& warning : drawn.warnings) {
    EXPECT_EQ(warning.find("not followed"), std::string::npos) << warning;
    EXPECT_EQ(warning.find("stays alone"), std::string::npos) << warning;
  }
}

}  // namespace
}  // namespace beatlas::segment
