#include "pipeline/report/doubt.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "pipeline/report/verdict.h"

namespace beatlas::report {
namespace {

/// Slices 10 mm apart, two phases: end-diastole and end-systole.
Segmentation believed(Structure structure, const std::vector<SliceBelief>& end_diastole,
                      const std::vector<SliceBelief>& end_systole) {
  Segmentation out;
  out.labels.grid.size = {4, 4, static_cast<int>(end_diastole.size())};
  out.labels.grid.mm_from_index = Affine::Identity();
  out.labels.grid.mm_from_index.linear().col(2) *= 10;
  out.end_diastole = 0;
  out.end_systole = 1;
  out.belief[structure] = {end_diastole, end_systole};
  return out;
}

std::vector<Doubt> doubts_of(const Segmentation& segmentation) {
  return report::doubts_of(segmentation, {});
}

TEST(Doubt, IsWhatLabelsAndPriorDoNotHaveInCommon) {
  const std::vector<Doubt> doubts =
      doubts_of(believed(Structure::LvBlood,
                         {{0, 0, 0}, {1000, 1000, 900}, {1000, 1200, 1000}, {0, 500, 0}, {0, 0, 0}},
                         {{0, 0, 0}, {500, 500, 500}, {500, 500, 500}, {500, 100, 50}, {0, 0, 0}}));
  ASSERT_EQ(doubts.size(), 2U);
  EXPECT_FALSE(doubts[0].end_systole);
  // 1900 of 2000 and of 2700: the slice that was missed is next to those that hold labels.
  EXPECT_NEAR(doubts[0].expected_dice, 2 * 1900.0 / 4700, 1e-12);
  EXPECT_NEAR(doubts[0].excess.ml, 1, 1e-12);
  EXPECT_NEAR(doubts[0].missed.ml, 8, 1e-12);
  ASSERT_EQ(doubts[0].missed.slices.size(), 2U);
  EXPECT_EQ(doubts[0].missed.slices[0].slice, 3);
  EXPECT_EQ(doubts[0].missed.slices[1].slice, 2);
  ASSERT_EQ(doubts[0].excess.slices.size(), 1U);
  EXPECT_EQ(doubts[0].excess.slices[0].slice, 1);
  EXPECT_EQ(doubts[1].phase, 1);
  EXPECT_NEAR(doubts[1].expected_dice, 2 * 1050.0 / 2600, 1e-12);
  EXPECT_NEAR(doubts[1].excess.ml, 4.5, 1e-12);
  EXPECT_EQ(volumes_in_words(doubts[1]),
            "4 ml may be too much, most in slice 3 (500 mm2 labelled, 100 likely, 9 % in common)");
  EXPECT_EQ(figures_in_words(doubts[1]), "ESV, EF and stroke volume of the LV");
}

TEST(Doubt, NamesTheSlicesThatLackAndThoseThatHoldTooMuchApart) {
  const std::vector<SliceBelief> slices{
      {1000, 1000, 1000}, {1500, 500, 500}, {500, 1000, 500}, {400, 1000, 400}, {500, 550, 500}};
  const Doubt doubt = doubts_of(believed(Structure::RvBlood, slices, slices)).front();
  EXPECT_EQ(volumes_in_words(doubt),
            "12 ml may be missing, most in slice 3 (400 mm2 labelled, 1000 likely, 40 % in common) "
            "and slice 2 (500 mm2 labelled, 1000 likely, 50 % in common); 10 ml may be too much, "
            "most in slice 1 (1500 mm2 labelled, 500 likely, 33 % in common)");
}

TEST(Doubt, LeavesOutAnotherBodyFarFromTheLabels) {
  const std::vector<SliceBelief> slices{{100, 100, 100}, {0, 10, 0}, {0, 400, 0}};
  const std::vector<Doubt> doubts = doubts_of(believed(Structure::RvBlood, slices, slices));
  EXPECT_NEAR(doubts.front().expected_dice, 200.0 / 210, 1e-12);
}

TEST(Doubt, OfAVentricleIsThatOfThePhasesThatItsFiguresComeFrom) {
  const std::vector<SliceBelief> sure{{1000, 1000, 950}, {1000, 1000, 950}};
  const std::vector<SliceBelief> unsure{{1000, 1000, 500}, {1000, 1000, 500}};
  Segmentation segmentation = believed(Structure::RvBlood, sure, sure);
  segmentation.belief[Structure::RvBlood] = {sure, sure, unsure};
  HeartFigures figures;
  figures.lv = {100, 40, 0, 1};
  figures.rv = {120, 60, 0, 2};
  const std::vector<Doubt> doubts = report::doubts_of(segmentation, figures);
  ASSERT_EQ(doubts.size(), 2U);
  EXPECT_EQ(doubts[0].phase, 0);
  EXPECT_NEAR(doubts[0].expected_dice, 0.95, 1e-12);
  EXPECT_EQ(doubts[1].phase, 2);
  EXPECT_NEAR(doubts[1].expected_dice, 0.5, 1e-12);
}

TEST(Doubt, IsNoneWhereNoPriorWasAsked) {
  EXPECT_TRUE(doubts_of(Segmentation()).empty());
  VerdictInput input;
  input.segmented = true;
  const std::vector<Finding> found = findings(input);
  EXPECT_TRUE(std::none_of(found.begin(), found.end(), [](const Finding& finding) {
    return finding.id.starts_with("expected");
  }));
}

TEST(Doubt, NamesStructurePhaseSliceAndFigure) {
  VerdictInput input;
  input.segmented = true;
  const std::vector<SliceBelief> sure{{1000, 1000, 950}, {1000, 1000, 950}};
  input.doubts = doubts_of(believed(Structure::RvBlood, sure, sure));
  const auto of_doubts = [&] {
    std::vector<Finding> out = findings(input);
    std::erase_if(out, [](const Finding& f) { return !f.id.starts_with("expected"); });
    return out;
  };
  ASSERT_EQ(of_doubts().size(), 1U);
  EXPECT_EQ(of_doubts().front().level, Level::Good);
  EXPECT_EQ(of_doubts().front().said,
            "expected Dice at end-diastole and end-systole: RV 0.95 and 0.95")
      << "in the order of the limits, each beside its own";
  input.doubts = doubts_of(believed(Structure::RvBlood, sure, {{1000, 1000, 950}, {940, 100, 0}}));
  ASSERT_EQ(of_doubts().size(), 1U);
  const Finding finding = of_doubts().front();
  EXPECT_EQ(finding.level, Level::Check);
  EXPECT_EQ(finding.id, "expected_rv_blood_es");
  EXPECT_EQ(finding.trouble, "Look before you trust ESV, EF and stroke volume of the RV");
  EXPECT_NE(
      finding.said.find("at end-systole (phase 1): expected Dice 0.62, 10 ml may be too much, "
                        "most in slice 1 (940 mm2 labelled, 100 likely"),
      std::string::npos)
      << finding.said;
}

TEST(Doubt, BearsOutAnAlarmOfASurfaceWhereThePriorExpectsSomethingElse) {
  const Segmentation segmentation =
      believed(Structure::RvBlood, {{1000, 1000, 950}, {1000, 1000, 700}, {0, 0, 0}},
               {{1000, 1000, 950}, {1000, 1000, 700}, {500, 500, 500}});
  LeakAlarm alarm{LeakKind::NoEdge, Structure::RvBlood, 0, Vec3(2, 2, 1), 500, 200, ""};
  const auto borne_out = [&] { return is_borne_out(alarm, segmentation, {}); };
  EXPECT_FALSE(borne_out()) << "slice 0 is as expected";
  alarm.lps_mm = Vec3(2, 2, 9);
  EXPECT_TRUE(borne_out()) << ".70 in slice 1, .78 is asked";
  alarm.phase = 1;
  EXPECT_FALSE(borne_out()) << ".63 is asked at end-systole";
  alarm.lps_mm = Vec3(2, 2, 20);
  EXPECT_TRUE(borne_out()) << "slice 2 is as a person told it";
  alarm.structure = Structure::LvBlood;
  EXPECT_TRUE(borne_out()) << "of the LV no prior is known";
}

TEST(Doubt, BearsOutAVolumeThatJumpsUnlessItIsThatOfAllThatIsInView) {
  Segmentation segmentation =
      believed(Structure::RvBlood, {{1000, 1000, 990}}, {{1000, 1000, 990}});
  segmentation.belief[Structure::Heart] = segmentation.belief[Structure::RvBlood];
  LeakAlarm alarm{LeakKind::VolumeJump, Structure::RvBlood, 0, Vec3::Zero(), 9, 6, ""};
  EXPECT_TRUE(is_borne_out(alarm, segmentation, {}));
  alarm.structure = Structure::Heart;
  EXPECT_FALSE(is_borne_out(alarm, segmentation, {}));
  segmentation.belief.clear();
  EXPECT_TRUE(is_borne_out(alarm, segmentation, {}));
}

}  // namespace
}  // namespace beatlas::report
