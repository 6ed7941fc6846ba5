#include "pipeline/report/prediction_intervals.h"

#include <gtest/gtest.h>

#include "pipeline/prior/model.h"

namespace beatlas::report {
namespace {

/// Areas [mm2] of three slices 10 mm apart, alike at end-diastole and end-systole but for `share`.
Segmentation heart(const SliceBelief& slice, double share = 0.4) {
  Segmentation out;
  out.labels.grid.size = {4, 4, 3};
  out.labels.grid.mm_from_index = Affine::Identity();
  out.labels.grid.mm_from_index.linear().col(2) *= 10;
  out.end_systole = 1;
  const SliceBelief small{share * slice.labelled_mm2, share * slice.expected_mm2,
                          share * slice.agreed_mm2};
  for (const Structure structure :
       {Structure::LvBlood, Structure::RvBlood, Structure::LvMyocardium}) {
    out.belief[structure] = {{slice, slice, slice}, {small, small, small}};
  }
  return out;
}

HeartFigures figures_of(const Segmentation& heart) {
  std::vector<VolumeCurve> volumes;
  for (const auto& [structure, phases] : heart.belief) {
    VolumeCurve curve{structure, {}};
    for (const auto& slices : phases) {
      curve.volume_ml.push_back(about_labels(slices).labelled_mm2 * 10 * 1e-3);
    }
    volumes.push_back(curve);
  }
  return heart_figures(volumes);
}

PredictionIntervals intervals_of(const Segmentation& heart) {
  return prediction_intervals(heart, figures_of(heart));
}

TEST(PredictionIntervals, HoldTheirFigures) {
  const Segmentation made = heart({5000, 5100, 4600});
  const PredictionIntervals found = intervals_of(made);
  ASSERT_EQ(found.size(), 9U);
  for (const auto& [key, interval] : found) {
    const double figure = *figure_of(figures_of(made), key);
    EXPECT_LT(interval.low, figure) << key;
    EXPECT_GT(interval.high, figure) << key;
    EXPECT_GE(interval.low, 0) << key;
  }
}

TEST(PredictionIntervals, WidenOnTheSideOfWhatThePriorExpectsBeside) {
  const PredictionIntervals sure = intervals_of(heart({5000, 5000, 4900}));
  const PredictionIntervals missed = intervals_of(heart({5000, 6500, 4900}));
  const PredictionIntervals excess = intervals_of(heart({5000, 3500, 3400}));
  for (const char* key : {"lv_edv_ml", "lv_esv_ml", "rv_edv_ml", "lv_mass_g"}) {
    EXPECT_GT(missed.at(key).high, sure.at(key).high + 1) << key;
    EXPECT_LT(excess.at(key).low, sure.at(key).low - 1) << key;
  }
}

TEST(PredictionIntervals, AreAsWideForASmallHeartAsForALargeOne) {
  const PredictionIntervals large = intervals_of(heart({5000, 5100, 4600}));
  const PredictionIntervals small = intervals_of(heart({500, 510, 460}));
  for (const auto& [key, interval] : large) {
    const double scale = key.ends_with("percent") ? 1 : 0.1;
    EXPECT_NEAR(small.at(key).low, scale * interval.low, 1e-9) << key;
    EXPECT_NEAR(small.at(key).high, scale * interval.high, 1e-9) << key;
  }
}

TEST(PredictionIntervals, StayWithinWhatAFigureCanBe) {
  const PredictionIntervals found = intervals_of(heart({5000, 9000, 500}, 0.02));
  for (const auto& [key, interval] : found) EXPECT_GE(interval.low, 0) << key;
  EXPECT_LE(found.at("lv_ef_percent").high, 100);
}

TEST(PredictionIntervals, AreNoneWhereNothingButLabelsIsKnown) {
  EXPECT_TRUE(prediction_intervals(Segmentation(), {}).empty());
  Segmentation made = heart({5000, 5100, 4600});
  const HeartFigures figures = figures_of(made);
  EXPECT_TRUE(prediction_intervals(made, {}).empty());
  // A person told what every slice of the LV holds at end-systole.
  for (SliceBelief& slice : made.belief[Structure::LvBlood][1]) slice = {2000, 2000, 2000};
  const PredictionIntervals found = prediction_intervals(made, figures);
  EXPECT_TRUE(found.contains("lv_edv_ml"));
  for (const char* key : {"lv_esv_ml", "lv_sv_ml", "lv_ef_percent"}) {
    EXPECT_FALSE(found.contains(key)) << key;
  }
  // Of two slices of three; then of one alone.
  made.belief[Structure::LvBlood][1][1] = {2000, 2100, 1900};
  EXPECT_FALSE(prediction_intervals(made, figures).contains("lv_esv_ml"));
  made.belief[Structure::LvBlood][1][0] = {2000, 2100, 1900};
  EXPECT_TRUE(prediction_intervals(made, figures).contains("lv_esv_ml"));
}

TEST(PredictionIntervals, AreOfTheModelThatComesWithTheProgram) {
  // New weights: fit anew, see scripts/fit_intervals.
  EXPECT_EQ(prior::Model::load(prior::default_model_path()).sha256(), kIntervalsModel);
}

}  // namespace
}  // namespace beatlas::report
