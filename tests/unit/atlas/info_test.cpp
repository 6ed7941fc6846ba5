#include "runtime/atlas/info.h"

#include <gtest/gtest.h>

#include "runtime/base/json_text.h"
#include "tests/unit/atlas/sample_manifest.h"

namespace beatlas::atlas {
namespace {

TEST(Info, HoldsTheKeysThatOtherProgramsRelyOn) {
  const nlohmann::json info = info_json(test::sample_manifest());
  EXPECT_EQ(info["format_version"], 7);
  EXPECT_EQ(info["frame_times_s"], nlohmann::json({0.0, 0.31, 0.55}));
  EXPECT_EQ(info["rr_interval_s"], 0.875);
  EXPECT_EQ(info["workspace_from_lps"].size(), 16U);
  EXPECT_EQ(info["structures"][1]["name"], "lv_blood");
  EXPECT_EQ(info["structures"][1]["volume_ml"][2], 125);
  EXPECT_EQ(info["items"][0]["path"], "surfaces/heart.drc");
  EXPECT_EQ(info["items"][0]["bytes"], 1234);
  EXPECT_EQ(info["items"][0]["sha256"], std::string(64, 'a'));
  EXPECT_EQ(info["phases"], 3);
  EXPECT_NEAR(info["source"]["spacing_mm"][2].get<double>(), 9.0, 1e-12);
}

TEST(Info, GivesTheEjectionFractionOfTheLvOnly) {
  Manifest manifest = test::sample_manifest();
  EXPECT_DOUBLE_EQ(ejection_fraction(manifest).value(), (125.0 - 50.0) / 125.0);
  manifest.structures[1].volume_ml = {0, 0, 0};
  EXPECT_FALSE(ejection_fraction(manifest).has_value());
  manifest.structures.pop_back();
  EXPECT_TRUE(info_json(manifest)["ejection_fraction"].is_null());
}

TEST(Info, SaysTheSameInWords) {
  const std::string text = info_text(test::sample_manifest());
  for (const char* part :
       {"format 7, scene anatomy", "0.875 s", "3 phases", "end-systole 1", "200 x 180 x 11",
        "1.500 x 1.250 x 9.000 mm", "60.0 %", "lv_blood", "125.0", "surfaces/heart.motion"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << " in\n" << text;
  }
  EXPECT_EQ(text.back(), '\n');
}

TEST(Info, TellsLevelsOfSurfacesAndTheirErrors) {
  Manifest manifest = test::sample_manifest();
  const auto told = [&] { return info_json(manifest)["surface_levels"]; };
  manifest.items.pop_back();
  ASSERT_EQ(told().size(), 1U);
  EXPECT_EQ(told()[0]["structure"], "heart");
  // Provenance is as given, and need not hold what ours does.
  for (const char* strange : {"{}", "[]", "3", "[3]", R"([{"structure": "heart", "level": 0}])",
                              R"([{"structure": [], "level": {}, "mean_mm": "low"}])"}) {
    manifest.provenance["surfaces"] = parse_json(strange);
    EXPECT_TRUE(told()[0]["mean_mm"].is_null()) << strange;
    EXPECT_FALSE(info_text(manifest).empty());
  }
  manifest.surface_edges_mm = {2, 4};
  manifest.items.push_back(
      {"surfaces/heart.level1.drc", "surface", "heart", 5, std::string(64, 'b'), 1});
  manifest.provenance["surfaces"] = {{{"structure", "heart"},
                                      {"level", 1},
                                      {"vertices", 4011},
                                      {"mean_mm", 0.0869},
                                      {"worst_phase_mm", 0.0908},
                                      {"bias_mm", -0.08}}};
  ASSERT_EQ(told().size(), 2U);
  EXPECT_EQ(told()[1]["edge_mm"], 4);
  EXPECT_EQ(told()[1]["mean_mm"], 0.0869);
  EXPECT_EQ(told()[0]["edge_mm"], 2);
  const std::string text = info_text(manifest);
  EXPECT_NE(text.find("4      4011         0.0869          0.0908"), std::string::npos) << text;
}

TEST(Info, TellsHowWellTheVolumeGivesBackTheImages) {
  Manifest manifest = test::sample_manifest();
  EXPECT_TRUE(info_json(manifest)["volume"].is_null());
  manifest.items.push_back(
      {"volumes/heart.volume.zst", "volume", "heart", 5, std::string(64, 'b')});
  // Provenance is as given, and need not hold what ours does.
  for (const char* strange : {"{}", "[]", "3", R"({"psnr_db": "high", "noise": []})"}) {
    manifest.provenance["volume"] = parse_json(strange);
    EXPECT_TRUE(info_json(manifest)["volume"]["psnr_db"].is_null()) << strange;
    EXPECT_EQ(info_text(manifest).find("PSNR"), std::string::npos) << strange;
  }
  manifest.provenance["volume"] = {
      {"noise", 15.5}, {"quantum", 46.5}, {"rms_error", 14.25}, {"psnr_db", 31.04}};
  EXPECT_EQ(info_json(manifest)["volume"]["psnr_db"], 31.04);
  EXPECT_NE(info_text(manifest).find("PSNR 31.0 dB, error 14.25 rms in images of noise 15.5"),
            std::string::npos);
}

TEST(Info, SaysThatAPackageWasNotMadeFromImages) {
  Manifest manifest = test::sample_manifest();
  manifest.source_size = {0, 0, 0};
  EXPECT_NE(info_text(manifest).find("no images"), std::string::npos);
}

}  // namespace
}  // namespace beatlas::atlas
