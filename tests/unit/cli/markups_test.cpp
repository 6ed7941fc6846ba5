#include "pipeline/cli/markups.h"

#include <gtest/gtest.h>

#include "pipeline/cli/label_names.h"
#include "runtime/base/error.h"
#include "runtime/base/json_text.h"

namespace beatlas::cli {
namespace {
using nlohmann::json;

json point(const std::string& label, const std::vector<double>& position) {
  // As 3D Slicer 5 writes them, with what is not looked at.
  return {{"id", "1"},
          {"label", label},
          {"description", ""},
          {"associatedNodeID", "vtkMRMLScalarVolumeNode1"},
          {"position", position},
          {"orientation", {-1.0, -0.0, -0.0, -0.0, -1.0, -0.0, 0.0, 0.0, 1.0}},
          {"selected", true},
          {"locked", false},
          {"visibility", true},
          {"positionStatus", "defined"}};
}

json markup(const std::string& type, const std::string& name, const std::vector<json>& points) {
  return {{"type", type},
          {"name", name},
          {"coordinateSystem", "LPS"},
          {"coordinateUnits", "mm"},
          {"locked", false},
          {"labelFormat", "%N-%d"},
          {"lastUsedControlPointNumber", points.size()},
          {"controlPoints", points},
          {"measurements", json::array()},
          {"display", {{"visibility", true}, {"opacity", 1.0}}}};
}

json file(const std::vector<json>& markups) {
  return {{"@schema",
           "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/"
           "Resources/Schema/markups-schema-v1.0.3.json#"},
          {"markups", markups}};
}

std::string refusal(const json& value) {
  try {
    (void)seeds_from_markups(value, {});
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
    return error.what();
  }
  ADD_FAILURE() << value << " was read";
  return {};
}

void expect_said(const json& value, const std::vector<std::string>& words) {
  const std::string said = refusal(value);
  for (const std::string& word : words) {
    EXPECT_NE(said.find(word), std::string::npos) << said << "\nlacks " << word;
  }
}

TEST(LabelNames, AreKnownWhateverTheirCaseAndSeparators) {
  for (const char* name : {"lv_blood", "LV blood", "LvBlood", "lv-blood", "LV_BLOOD-3",
                           "lvblood 12", "LV", "3", "3-1", " lv . blood "}) {
    EXPECT_EQ(label_from_name(name), std::uint8_t{kLabelLvBlood}) << name;
  }
  EXPECT_EQ(label_from_name("Background_1-4"), std::uint8_t{kLabelBackground});
  EXPECT_EQ(label_from_name("0"), std::uint8_t{kLabelBackground});
  EXPECT_EQ(label_from_name("Myocardium"), std::uint8_t{kLabelLvMyocardium});
  EXPECT_EQ(label_from_name("rv blood"), std::uint8_t{kLabelRvBlood});
  EXPECT_EQ(label_from_name("Left atrium_2"), std::uint8_t{kLabelLaBlood});
  EXPECT_EQ(label_from_name("ra_blood"), std::uint8_t{kLabelRaBlood});
  EXPECT_EQ(label_from_name("7"), std::uint8_t{kLabelAorta});
  EXPECT_EQ(label_from_name("rest_of_heart"), std::uint8_t{kLabelRestOfHeart});
  for (const char* name :
       {"", "F-1", "8", "3d", "-", "lv blood pool", "lv 3 blood", "1lv", "99999999999999999999",
        "lv\xC3\xA9", "left_ventricle", "Right ventricle-1"}) {
    EXPECT_EQ(label_from_name(name), std::nullopt) << name;
  }
}

TEST(LabelNames, ThatAreUnknownAreAnsweredWithWhatTheyMayMean) {
  // Cavity or wall: nobody but its user knows.
  EXPECT_EQ(what_it_may_be("left_ventricle"), "did you mean 'lv_blood' or 'lv_myocardium'?");
  EXPECT_EQ(what_it_may_be("Left Ventricle@4-1"), "did you mean 'lv_blood' or 'lv_myocardium'?");
  EXPECT_EQ(what_it_may_be("right-ventricle"), "did you mean 'rv_blood' or 'rest_of_heart'?");
  EXPECT_EQ(what_it_may_be("backgrund@4-2"), "did you mean 'background'?");
  EXPECT_EQ(what_it_may_be("spleen").rfind("call it one of background, rv_blood", 0), 0U);
}

TEST(LabelMap, IsReadFromPresetsAndPairs) {
  EXPECT_EQ(label_map_from_word("acdc"), (LabelMap{{1, 1}, {2, 2}, {3, 3}}));
  EXPECT_EQ(label_map_from_word("mms"), (LabelMap{{1, 3}, {2, 2}, {3, 1}}));
  EXPECT_EQ(label_map_from_word("200=LV blood,7=background"), (LabelMap{{7, 0}, {200, 3}}));
  EXPECT_EQ(own_label_map(), (LabelMap{{1, 1}, {2, 2}, {3, 3}, {4, 4}, {5, 5}, {6, 6}, {7, 7}}));
  for (const char* word : {"", "x", "1", "1=", "=lv", "1=spleen", "0=lv", "256=lv", "1=lv,",
                           "1=lv,1=rv", "1=lv;2=rv"}) {
    try {
      (void)label_map_from_word(word);
      ADD_FAILURE() << word;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::Usage);
      EXPECT_NE(std::string(error.what()).find("--label-map"), std::string::npos) << error.what();
    }
  }
}

TEST(Markups, ListsBecomeBallsByThePointsLabelOrElseByTheListsName) {
  const auto seeds =
      seeds_from_markups(file({markup("Fiducial", "LV blood",
                                      {point("LV blood-1", {1, 2, 3}), point("RV-7", {4, 5, 6}),
                                       point("somewhere", {7, 8, 9})}),
                               markup("Fiducial", "F", {point("0", {-1, 0, 0})})}),
                         {.phase = 4, .radius_mm = 3});
  ASSERT_EQ(seeds.size(), 4U);
  const std::vector<int> labels = {kLabelLvBlood, kLabelRvBlood, kLabelLvBlood, kLabelBackground};
  for (std::size_t at = 0; at < 4; ++at) {
    EXPECT_EQ(seeds[at].label, labels[at]) << at;
    EXPECT_EQ(seeds[at].phase, 4);
    EXPECT_EQ(seeds[at].radius_mm, 3);
    EXPECT_TRUE(seeds[at].stroke_lps_mm.empty());
  }
  EXPECT_EQ(seeds[1].lps_mm, Vec3(4, 5, 6));
}

TEST(Markups, InRasOrMicrometresAreTurnedIntoLpsMillimetres) {
  json ras = markup("Fiducial", "lv", {point("lv-1", {1, 2, 3})});
  ras["coordinateSystem"] = "RAS";
  EXPECT_EQ(seeds_from_markups(file({ras}), {})[0].lps_mm, Vec3(-1, -2, 3));
  json small = markup("Fiducial", "lv", {point("lv-1", {1000, 2000, -3000})});
  small["coordinateUnits"] = {"um", "UCUM", "micrometer"};
  EXPECT_TRUE(seeds_from_markups(file({small}), {})[0].lps_mm.isApprox(Vec3(1, 2, -3), 1e-12));
  // The shortest file that Slicer documents: no units, no status, no name.
  const json shortest = {
      {"markups",
       {{{"type", "Fiducial"},
         {"controlPoints", json::array({{{"label", "LV-1"}, {"position", {1, 2, 3}}}})}}}}};
  EXPECT_EQ(seeds_from_markups(shortest, {})[0].lps_mm, Vec3(1, 2, 3));
}

TEST(Markups, CurvesBecomeStrokesAndClosedOnesReturn) {
  const std::vector<json> points = {point("myo-1", {0, 0, 0}), point("myo-2", {1, 0, 0}),
                                    point("myo-3", {1, 1, 0})};
  const auto open = seeds_from_markups(file({markup("Curve", "myo", points)}), {});
  ASSERT_EQ(open.size(), 1U);
  EXPECT_EQ(open[0].stroke_lps_mm, (std::vector<Vec3>{{1, 0, 0}, {1, 1, 0}}));
  const auto closed = seeds_from_markups(file({markup("ClosedCurve", "myo", points)}), {});
  ASSERT_EQ(closed.size(), 1U);
  EXPECT_EQ(closed[0].stroke_lps_mm, (std::vector<Vec3>{{1, 0, 0}, {1, 1, 0}, {0, 0, 0}}));
}

TEST(Markups, TellTheirPhaseByTheEndOfAName) {
  const auto seeds =
      seeds_from_markups(file({markup("Fiducial", "lv_blood@5",
                                      {point("lv_blood@5-1", {0, 0, 0}), point("rv", {0, 0, 0}),
                                       point("rv@7", {0, 0, 0}), point("lv@all", {0, 0, 0})}),
                               markup("Fiducial", "lv", {point("lv-1", {0, 0, 0})})}),
                         {.phase = 2});
  ASSERT_EQ(seeds.size(), 5U);
  const std::vector<int> phases = {5, 5, 7, -1, 2};
  for (std::size_t at = 0; at < 5; ++at) EXPECT_EQ(seeds[at].phase, phases[at]) << at;
  expect_said(file({markup("Fiducial", "lv@ed", {point("x", {0, 0, 0})})}), {"lv@ed", "phase"});
  expect_said(file({markup("Fiducial", "lv@5000", {point("x", {0, 0, 0})})}), {"phase"});
}

TEST(Markups, WhosePointsAreOnlyCountedTakeTheNameOfTheirList) {
  json counted = markup("Fiducial", "background", {point("1", {0, 0, 0}), point("2", {1, 0, 0})});
  counted["labelFormat"] = "%d";
  for (const segment::Seed& seed : seeds_from_markups(file({counted}), {})) {
    EXPECT_EQ(seed.label, kLabelBackground);
  }
}

TEST(Markups, PointsThatWereNotPlacedArePassedOver) {
  json unplaced = point("lv-2", {0, 0, 0});
  unplaced["positionStatus"] = "undefined";
  json shown = unplaced;
  shown["positionStatus"] = "preview";
  EXPECT_EQ(seeds_from_markups(
                file({markup("Fiducial", "lv", {unplaced, point("lv-1", {1, 1, 1}), shown})}), {})
                .size(),
            1U);
  expect_said(file({markup("Fiducial", "lv", {unplaced})}), {"no point"});
}

TEST(Markups, ADescriptionMayTellTheRadius) {
  json large = point("lv-1", {0, 0, 0});
  large["description"] = "radius 6.5 mm";
  json talk = point("lv-2", {0, 0, 0});
  talk["description"] = "radius looks large";
  const auto seeds =
      seeds_from_markups(file({markup("Fiducial", "lv", {large, talk})}), {.radius_mm = 3});
  ASSERT_EQ(seeds.size(), 2U);
  EXPECT_EQ(seeds[0].radius_mm, 6.5);
  EXPECT_EQ(seeds[1].radius_mm, 3);
  large["description"] = "radius 600 mm";
  expect_said(file({markup("Fiducial", "lv", {large})}), {"/controlPoints/0/description", "50 mm"});
}

TEST(Markups, GiveBackTheSeedsTheyWereWrittenFrom) {
  const std::vector<segment::Seed> seeds = {
      {.label = kLabelLvBlood, .lps_mm = {0.1, -20.25, 1e-3}, .radius_mm = 6.5, .phase = 5},
      {.label = kLabelLvBlood, .lps_mm = {1, 2, 3}, .radius_mm = 0.1, .phase = 5},
      {.label = kLabelBackground,
       .lps_mm = {7, 8, 9},
       .radius_mm = 1.0 / 3,
       .phase = -1,
       .stroke_lps_mm = {{1, 1, 1}, {2, 2, 2}}},
      {.label = kLabelRestOfHeart, .lps_mm = {1, 1, 1}, .phase = 0, .stroke_lps_mm = {{2, 1, 1}}}};
  const json markups = seeds_to_markups(seeds);
  EXPECT_TRUE(holds_markups(markups));
  const auto back =
      seeds_from_markups(parse_json(json_text(markups)), {.phase = 3, .radius_mm = 9});
  ASSERT_EQ(back.size(), seeds.size());
  for (std::size_t at = 0; at < seeds.size(); ++at) {
    EXPECT_EQ(back[at].label, seeds[at].label) << at;
    EXPECT_EQ(back[at].phase, seeds[at].phase) << at;
    EXPECT_EQ(back[at].radius_mm, seeds[at].radius_mm) << at;
    EXPECT_EQ(back[at].lps_mm, seeds[at].lps_mm) << at;
    EXPECT_EQ(back[at].stroke_lps_mm, seeds[at].stroke_lps_mm) << at;
  }
}

TEST(Markups, ThatCannotBeMeantAreRefusedByTheirPlace) {
  expect_said(file({markup("Fiducial", "F", {point("F-1", {0, 0, 0})})}),
              {"/markups/0/name", "'F'", "lv_myocardium"});
  expect_said(file({markup("Plane", "lv", {point("lv", {0, 0, 0})})}),
              {"/markups/0/type", "Curve"});
  expect_said(file({markup("Curve", "lv", {point("lv", {0, 0, 0}), point("rv", {1, 0, 0})})}),
              {"/controlPoints/1", "stroke"});
  expect_said(file({markup("Fiducial", "lv", {point("lv", {0, 0})})}), {"position"});
  expect_said(file({markup("Fiducial", "lv", {point("lv", {0, 0, 6000})})}), {"position"});
  json wrong = markup("Fiducial", "lv", {point("lv", {0, 0, 0})});
  wrong["coordinateSystem"] = "IJK";
  expect_said(file({wrong}), {"/markups/0/coordinateSystem", "LPS"});
  wrong = markup("Fiducial", "lv", {point("lv", {0, 0, 0})});
  wrong["coordinateUnits"] = "m";
  expect_said(file({wrong}), {"coordinateUnits"});
  json newer = file({markup("Fiducial", "lv", {point("lv", {0, 0, 0})})});
  newer["@schema"] = "markups-schema-v2.0.0.json#";
  expect_said(newer, {"/@schema", "1.x"});
  expect_said({{"markups", 3}}, {"/markups"});
  expect_said(file({}), {"no point"});
}

}  // namespace
}  // namespace beatlas::cli
