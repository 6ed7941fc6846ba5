#include "pipeline/report/verdict.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "pipeline/report/base64.h"
#include "pipeline/report/coarse_surface.h"
#include "pipeline/report/normal_ranges.h"
#include "pipeline/report/report_data.h"

namespace beatlas::report {
namespace {

/// A heart nothing is wrong with.
VerdictInput sound() {
  VerdictInput out;
  out.segmented = true;
  out.segmentation = heart_figures({{Structure::LvBlood, {150, 100, 55, 120}},
                                    {Structure::RvBlood, {180, 130, 80, 150}},
                                    {Structure::LvMyocardium, {130, 132, 134, 131}}});
  out.package = out.segmentation;
  out.worst_gap_percent = 0.5;
  out.checks = 40;
  out.surfaces = {{Structure::Heart, 0, 0, 0.1}};
  out.uncertain_percent = 2.0;
  out.phases = 20;
  out.rr_interval_s = 0.8;
  return out;
}

Level level_of(const VerdictInput& input, const std::string& id) {
  for (const Finding& finding : findings(input)) {
    if (finding.id == id) return finding.level;
  }
  ADD_FAILURE() << "no finding " << id;
  return Level::Good;
}

TEST(HeartFigures, AreTheTextbooksOnes) {
  const HeartFigures figures = sound().segmentation;
  EXPECT_DOUBLE_EQ(figures.lv->stroke_ml(), 95);
  EXPECT_NEAR(figures.lv->ef_percent(), 63.333, 1e-3);
  EXPECT_EQ(figures.lv->es, 2);
  EXPECT_DOUBLE_EQ(*figures.lv_mass_g, 1.05 * 130);
  EXPECT_NEAR(*figures.muscle_change_percent, 100 * 4 / 131.75, 1e-9);
  EXPECT_DOUBLE_EQ(*figure_of(figures, "rv_sv_ml"), 100);
  EXPECT_DOUBLE_EQ(*figure_of(figures, "lv_edv_ml"), 150);
  EXPECT_FALSE(figure_of(heart_figures({}), "lv_mass_g").has_value());
}

TEST(NormalRanges, HaveASourceAndAnOrder) {
  for (const NormalRange& range : normal_ranges()) {
    EXPECT_LT(range.men_low, range.men_high) << range.figure;
    EXPECT_LT(range.women_low, range.women_high) << range.figure;
    EXPECT_LT(static_cast<std::size_t>(range.source), normal_sources().size());
    EXPECT_TRUE(figure_of(sound().segmentation, range.figure).has_value()) << range.figure;
  }
}

TEST(NormalRanges, OfTheOtherConventionAreLeftOut) {
  const auto other = [](Papillary labelled) {
    std::vector<std::string> out;
    const nlohmann::json told = normal_to_json(labelled);
    for (const nlohmann::json& range : told.at("ranges")) {
      EXPECT_EQ(range.at("men").is_null(), range.contains("other"));
      EXPECT_EQ(range.at("women").is_null(), range.contains("other"));
      if (range.contains("other")) out.push_back(range.at("figure"));
    }
    return out;
  };
  EXPECT_EQ(other(Papillary::Blood), (std::vector<std::string>{"lv_mass_g"}));
  EXPECT_EQ(other(Papillary::Muscle),
            (std::vector<std::string>{"lv_ef_percent", "lv_edv_ml", "lv_esv_ml", "lv_sv_ml"}));
}

TEST(Verdict, IsGoodWhereNothingIsWrong) {
  EXPECT_EQ(verdict(findings(sound())), Level::Good);
  for (const Finding& finding : findings(sound())) {
    EXPECT_FALSE(finding.said.empty() || finding.limit.empty() || finding.why.empty())
        << finding.id;
  }
}

TEST(Verdict, RejectsWhatCannotBeUsed) {
  VerdictInput input = sound();
  input.refused = "the volume of heart differs";
  EXPECT_EQ(level_of(input, "package"), Level::Rejected);
  input = sound();
  input.surfaces[0].open_edges = 1;
  EXPECT_EQ(level_of(input, "surfaces"), Level::Rejected);
  input = sound();
  input.segmentation.lv->esv_ml = 0.98 * input.segmentation.lv->edv_ml;
  EXPECT_EQ(level_of(input, "ef_possible"), Level::Rejected);
  EXPECT_EQ(verdict(findings(input)), Level::Rejected);
}

TEST(Verdict, RejectsAStudyWithoutWhatItsSceneNeeds) {
  VerdictInput input = sound();
  input.segmentation.rv.reset();
  EXPECT_EQ(level_of(input, "structures"), Level::Check) << "the scene does without it";
  EXPECT_TRUE(rejections(findings(input)).empty());
  input.missing = {Structure::RvBlood};
  const WaysToFind ways = ways_to_find(input.missing, 3, false, false);
  input.how_to_find = ways.how;
  input.finding_commands = ways.commands;
  const std::vector<Finding> all = findings(input);
  EXPECT_EQ(all.front().id, "structures") << "what comes first on the page";
  EXPECT_EQ(all.front().level, Level::Rejected);
  EXPECT_EQ(std::count_if(all.begin(), all.end(),
                          [](const Finding& finding) { return finding.id == "structures"; }),
            1);
  ASSERT_EQ(rejections(all).size(), 1U);
  EXPECT_NE(rejections(all)[0].find("rv_blood"), std::string::npos);
  EXPECT_FALSE(all.front().how.empty());
  EXPECT_EQ(all.front().commands,
            (std::vector<std::string>{"beatlas seeds . add --label rv_blood --ras=X,Y,Z --phase 3",
                                      "beatlas build --study . -o heart.beatlas"}));
}

TEST(Verdict, AStructureIsMissingWhereAPhaseLacksIt) {
  const std::vector<VolumeCurve> curves{{Structure::LvBlood, {150, 55}},
                                        {Structure::RvBlood, {120, 0}}};
  EXPECT_EQ(
      missing_structures(curves, {Structure::LvBlood, Structure::RvBlood, Structure::LvMyocardium}),
      (std::vector<Structure>{Structure::RvBlood, Structure::LvMyocardium}));
  EXPECT_TRUE(missing_structures(curves, {Structure::LvBlood}).empty());
  EXPECT_TRUE(missing_structures({}, {}).empty());
}

TEST(Verdict, OffersToPaintWhatIsMissingWhereLabelsWereDrawn) {
  const WaysToFind ways = ways_to_find({Structure::LvBlood}, 0, true, true);
  EXPECT_EQ(ways.commands, std::vector<std::string>{"beatlas build --study ."});
  EXPECT_NE(ways.how.find("segment/labels.nii.gz"), std::string::npos) << ways.how;
}

TEST(Commands, AreOurOwnWhateverIsWrong) {
  Place place;
  place.lps_mm = Vec3(1, -2.04, 3);
  place.phase = 4;
  const std::string build = "beatlas build --study .";
  EXPECT_EQ(correcting_commands(place, false),
            (std::vector<std::string>{
                "beatlas seeds . add --label LABEL --lps=1.0,-2.0,3.0 --phase 4", build}));
  place.seeds = {{kLabelBackground, Vec3(5, 6, 7), 2.5, 3}, {kLabelRvBlood, Vec3(8, 9, 1), 4, -1}};
  EXPECT_EQ(correcting_commands(place, false),
            (std::vector<std::string>{"beatlas seeds . add --label background --lps=5.0,6.0,7.0 "
                                      "--phase 3 --radius 2.5",
                                      "beatlas seeds . add --label rv_blood --lps=8.0,9.0,1.0 "
                                      "--phase -1 --radius 4.0",
                                      build}));
  EXPECT_EQ(correcting_commands(place, true), std::vector<std::string>{build});
}

TEST(HeartFigures, OfOtherCurvesAreThoseAtTheSamePhases) {
  const HeartFigures labels = sound().segmentation;
  // Its own extremes are elsewhere.
  const HeartFigures made = ventricles_at(
      labels, {{Structure::LvBlood, {140, 142, 60, 50}}, {Structure::RvBlood, {170, 171}}});
  ASSERT_TRUE(made.lv.has_value());
  EXPECT_EQ(made.lv->edv_ml, 140);
  EXPECT_EQ(made.lv->esv_ml, 60);
  EXPECT_EQ(made.lv->ed, labels.lv->ed);
  EXPECT_EQ(made.lv->es, labels.lv->es);
  EXPECT_FALSE(made.rv.has_value()) << "it has no such phase";
  EXPECT_FALSE(ventricles_at({}, {{Structure::LvBlood, {140, 60}}}).lv.has_value());
}

TEST(Verdict, TellsWhatDiffersFromTheSegmentation) {
  VerdictInput input = sound();
  input.worst_gap_percent = 5.14;
  input.worst_gap_of = "the surface of aorta";
  const std::vector<Finding> all = findings(input);
  const auto found = std::find_if(all.begin(), all.end(),
                                  [](const Finding& finding) { return finding.id == "package"; });
  ASSERT_NE(found, all.end());
  EXPECT_EQ(found->said,
            "largest difference 5.1 % of the largest volume in the beat, the surface of aorta");
}

/// What is said of a finding, its trouble before it.
std::string told(const VerdictInput& input, const std::string& id) {
  for (const Finding& finding : findings(input)) {
    if (finding.id == id) return finding.trouble + ": " + finding.said;
  }
  ADD_FAILURE() << "no finding " << id;
  return "";
}

TEST(Verdict, SaysMissingOrTooMuchWhereTheSignIsKnown) {
  VerdictInput input = sound();
  input.worst_gap_percent = 5.14;
  input.worst_gap_sign = -1;
  EXPECT_EQ(told(input, "package"),
            "Volume is missing in the package: largest difference 5.1 % of the largest volume in "
            "the beat missing");
  input.worst_gap_sign = 1;
  EXPECT_EQ(told(input, "package"),
            "The package has too much volume: largest difference 5.1 % of the largest volume in "
            "the beat too much");
  input = sound();
  input.segmentation.rv->edv_ml = 140;
  EXPECT_EQ(told(input, "strokes"),
            "The RV ejects less than the LV: LV 95 ml, RV 60 ml: 45 % of their mean missing in the "
            "RV or too much in the LV");
  input.segmentation.lv->esv_ml = 148;
  EXPECT_EQ(told(input, "ef_possible"), "The LV ejects too little for any heart: LV 1 %");
  input.segmentation.lv->esv_ml = 1;
  EXPECT_EQ(told(input, "ef_possible"), "The LV ejects too much for any heart: LV 99 %");
  input.segmentation.lv = VentricleFigures{1000, 984.52, 0, 1};
  EXPECT_EQ(told(input, "ef_possible"), "The LV ejects too little for any heart: LV 2 %");
  input.segmentation.lv->esv_ml = 985.2;
  EXPECT_EQ(told(input, "ef_possible"), "The LV ejects too little for any heart: LV 1 %")
      << "1.48 %, not 1.5 % rounded once more";
  input = sound();
  input.package->lv->esv_ml = 60;
  EXPECT_EQ(told(input, "ef_agrees"),
            "The LV of the package has too low an EF for its labels: LV 60.0 % for the labels' "
            "63.3 % (phases 0 and 2), RV 55.6 % for the labels' 55.6 % (phases 0 and 2)");
  input.package->rv->esv_ml = 70;
  EXPECT_EQ(told(input, "ef_agrees").rfind("The RV of the package has too high an EF", 0), 0U);
  input = sound();
  input.segmentation.rv.reset();
  EXPECT_EQ(told(input, "structures"), "A structure is missing: RV blood");
  input.missing = {Structure::RvBlood};
  EXPECT_EQ(told(input, "structures"), "A structure that the scene needs is missing: rv_blood");
  input = sound();
  input.phases = 4;
  EXPECT_EQ(told(input, "beat").rfind("Phases are missing: ", 0), 0U);
  input.phases = 20;
  input.rr_interval_s = 2;
  EXPECT_EQ(told(input, "beat").rfind("The R-R interval is too long: ", 0), 0U);
}

TEST(Verdict, AsksWhetherItIsThisHeartBeforeHowItWasMade) {
  VerdictInput input = sound();
  input.surfaces = {{Structure::Heart, 0, 0, 50}};
  input.failed_checks = {"a level of detail is rough"};
  input.worst_gap_percent = 20;
  input.segmentation = heart_figures({{Structure::LvBlood, {150, 55}},
                                      {Structure::RvBlood, {150, 140}},
                                      {Structure::LvMyocardium, {130, 130}}});
  input.package = input.segmentation;
  std::vector<std::string> bad;
  for (const Finding& finding : findings(input)) {
    if (finding.level != Level::Good) bad.push_back(finding.id);
  }
  EXPECT_EQ(bad, (std::vector<std::string>{"strokes", "package", "checks", "surfaces"}));
  // Why there is no package comes before all.
  input.refused = "a volume is lost";
  EXPECT_EQ(findings(input).front().id, "package");
}

TEST(Places, SayWhetherVolumeIsMissingOrTooMuchAndWhen) {
  Segmentation segmentation;
  LeakAlarm alarm;
  alarm.kind = LeakKind::VolumeJump;
  alarm.structure = Structure::RvBlood;
  alarm.phase = 8;
  alarm.sign = -1;
  segmentation.alarms = {alarm};
  EXPECT_EQ(leak_places(segmentation).front().title,
            "Volume missing in phase 8: the right ventricle's blood");
  segmentation.alarms.front().sign = 1;
  EXPECT_EQ(leak_places(segmentation).front().title,
            "Too much volume in phase 8: the right ventricle's blood");
}

TEST(Verdict, TellsOfEachSurfaceWithItselfAlone) {
  VerdictInput input = sound();
  EXPECT_EQ(told(input, "surfaces"),
            "A surface is torn or folds: 0 open edges or pinched vertices; at most 0.10 % of "
            "triangles cut others of the same surface");
}

TEST(Verdict, AsksToCheckWhatIsDoubtful) {
  const auto doubtful = [](const std::string& id, const auto& spoil) {
    VerdictInput input = sound();
    spoil(input);
    EXPECT_EQ(level_of(input, id), Level::Check) << id;
    EXPECT_EQ(verdict(findings(input)), Level::Check) << id;
  };
  doubtful("package", [](VerdictInput& v) { v.worst_gap_percent = 5.1; });
  doubtful("package", [](VerdictInput& v) { v.worst_gap_percent.reset(); });
  doubtful("up_to_date", [](VerdictInput& v) { v.stale = {"mesh"}; });
  doubtful("structures", [](VerdictInput& v) { v.segmentation.rv.reset(); });
  doubtful("leaks", [](VerdictInput& v) { v.leaks.emplace_back(); });
  doubtful("strokes", [](VerdictInput& v) { v.segmentation.rv->edv_ml = 200; });
  doubtful("muscle", [](VerdictInput& v) { v.segmentation.muscle_change_percent = 15.1; });
  doubtful("ef_agrees", [](VerdictInput& v) { v.package->lv->esv_ml = 60; });
  doubtful("ef_agrees", [](VerdictInput& v) { v.package->rv->edv_ml = 165; });
  doubtful("surfaces", [](VerdictInput& v) { v.surfaces[0].crossing_percent = 1.1; });
  doubtful("boundaries", [](VerdictInput& v) { v.uncertain_percent = 10.1; });
  doubtful("slice_shifts", [](VerdictInput& v) { v.slice_shifts_mm = {{0, 1}, {3.1, 4}}; });
  doubtful("slice_timing", [](VerdictInput& v) { v.slice_lags = {0, 0, -2, 1}; });
  doubtful("beat", [](VerdictInput& v) { v.rr_interval_s = 0.3; });
  doubtful("beat", [](VerdictInput& v) { v.phases = 7; });
  doubtful("checks", [](VerdictInput& v) { v.failed_checks = {"rv_blood: stray"}; });
  doubtful("warnings", [](VerdictInput& v) { v.warnings = {"views disagree"}; });
}

TEST(Verdict, LeavesItToThePriorWhetherWhatIsHardlySeenIsWrong) {
  VerdictInput input = sound();
  input.other_leaks = 2;
  input.uncertain_percent = 10.1;
  EXPECT_EQ(level_of(input, "leaks"), Level::Good);
  EXPECT_EQ(level_of(input, "boundaries"), Level::Check) << "no prior was asked";
  input.doubts = {{Structure::LvBlood, false, 0, 0.95, {}, {}}};
  EXPECT_EQ(verdict(findings(input)), Level::Good);
  const std::vector<Finding> all = findings(input);
  const auto leaks = std::find_if(all.begin(), all.end(),
                                  [](const Finding& finding) { return finding.id == "leaks"; });
  ASSERT_NE(leaks, all.end());
  EXPECT_EQ(leaks->said,
            "no alarm that the prior bears out; 2 places to look at, where labels are as expected");
}

TEST(Verdict, TellsWhatStagesRemarkedAndJudgesItByWhatItCost) {
  VerdictInput input = sound();
  input.remarks = {"mesh: heart was mended", "field: cut flat"};
  const std::vector<Finding> all = findings(input);
  EXPECT_EQ(verdict(all), Level::Good);
  EXPECT_EQ(all.back().id, "remarks");
  EXPECT_EQ(all.back().said, "mesh: heart was mended; field: cut flat");
}

TEST(UncertainPlaces, AreWhereMostOfABoundaryIsHardlyKnown) {
  Grid grid{{40, 40, 4}, Affine::Identity()};
  grid.mm_from_index.linear() = Vec3(2, 2, 8).asDiagonal();
  BoundaryUncertainty uncertainty;
  auto& phases = uncertainty[Structure::RvBlood];
  phases.resize(3);
  const auto add = [&](std::size_t phase, int i, int j, int k, float sigma_mm) {
    phases[phase].push_back({static_cast<std::uint32_t>(grid.offset(i, j, k)), sigma_mm});
  };
  for (int i = 5; i < 13; ++i) add(1, i, 20, 2, 3.0F);   // 8 x 16 mm2, hardly known
  for (int i = 0; i < 40; ++i) add(1, i, 35, 2, 1.5F);   // well enough
  for (int i = 25; i < 29; ++i) add(1, i, 10, 1, 4.0F);  // too little of it
  add(0, 9, 20, 2, 3.0F);
  const std::vector<Place> found = uncertain_places(uncertainty, grid, {});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].phase, 1);
  EXPECT_EQ(found[0].structure, Structure::RvBlood);
  EXPECT_NEAR((found[0].lps_mm - Vec3(17, 40, 16)).norm(), 0, 4);
  EXPECT_TRUE(uncertain_places(uncertainty, grid, found).empty()) << "told by an alarm already";
  EXPECT_NEAR(uncertain_percent(uncertainty, Structure::RvBlood, 2), 100.0 * 13 / 53, 1e-9);
  EXPECT_EQ(uncertain_percent(uncertainty, Structure::Heart, 2), 0);
}

TEST(Base64, FollowsItsStandard) {
  const auto of = [](std::string_view text) {
    return base64({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  };
  EXPECT_EQ(of(""), "");
  EXPECT_EQ(of("f"), "Zg==");
  EXPECT_EQ(of("fo"), "Zm8=");
  EXPECT_EQ(of("foobar"), "Zm9vYmFy");
  EXPECT_EQ(of("\xff\xfe\xfd"), "//79");
}

/// A sphere of 10 mm by latitude and longitude that grows to 12 mm.
SurfaceCycle sphere() {
  SurfaceCycle out{Structure::Heart, {}, {{}, {}}};
  constexpr std::uint32_t kRings = 40;
  constexpr std::uint32_t kAround = 60;
  const auto add = [&](const Vec3& direction) {
    out.positions[0].push_back((10 * direction).cast<float>());
    out.positions[1].push_back((12 * direction).cast<float>());
  };
  add(Vec3::UnitZ());
  for (std::uint32_t r = 1; r < kRings; ++r) {
    for (std::uint32_t a = 0; a < kAround; ++a) {
      const double t = M_PI * r / kRings;
      const double p = 2 * M_PI * a / kAround;
      add({std::sin(t) * std::cos(p), std::sin(t) * std::sin(p), std::cos(t)});
    }
  }
  add(-Vec3::UnitZ());
  const auto at = [](std::uint32_t r, std::uint32_t a) {
    return 1 + (r - 1) * kAround + a % kAround;
  };
  for (std::uint32_t a = 0; a < kAround; ++a) {
    out.triangles.push_back({0, at(1, a), at(1, a + 1)});
    for (std::uint32_t r = 1; r + 1 < kRings; ++r) {
      out.triangles.push_back({at(r, a), at(r + 1, a), at(r + 1, a + 1)});
      out.triangles.push_back({at(r, a), at(r + 1, a + 1), at(r, a + 1)});
    }
    out.triangles.push_back({at(kRings - 1, a), at(kRings, 0), at(kRings - 1, a + 1)});
  }
  return out;
}

double volume_ml(const CoarseSurface& surface, std::size_t phase) {
  double six_times = 0;
  for (const auto& t : surface.triangles) {
    const auto& x = surface.positions[phase];
    six_times += double(x[t[0]].dot(x[t[1]].cross(x[t[2]])));
  }
  return six_times / 6000;
}

TEST(CoarseSurface, StaysClosedAndMovesAsTheWholeDoes) {
  const SurfaceCycle whole = sphere();
  const CoarseSurface coarse = coarse_surface(whole, 400, 0);
  ASSERT_EQ(coarse.positions.size(), 2U);
  EXPECT_LE(coarse.positions[0].size(), 600U);
  EXPECT_GE(coarse.positions[0].size(), 300U);
  EXPECT_EQ(coarse.triangles.size(), 2 * coarse.positions[0].size() - 4) << "closed, of one piece";
  for (std::size_t v = 0; v < coarse.positions[0].size(); ++v) {
    EXPECT_NEAR(coarse.positions[0][v].norm(), 10, 1e-4);
    EXPECT_LT((coarse.positions[1][v] - 1.2F * coarse.positions[0][v]).norm(), 1e-4);
  }
  // A polyhedron in a sphere of some 400 corners lacks two percent of it.
  EXPECT_NEAR(volume_ml(coarse, 0), 4.18879, 0.15);
  EXPECT_NEAR(volume_ml(coarse, 1), 7.23823, 0.26);
  EXPECT_EQ(coarse_surface(whole, 5000, 0).triangles, whole.triangles);
}

}  // namespace
}  // namespace beatlas::report
