#include "runtime/atlas/manifest.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "runtime/base/json_text.h"
#include "tests/json_file.h"
#include "tests/unit/atlas/sample_manifest.h"

namespace beatlas::atlas {
namespace {

using nlohmann::json;

json sample() { return manifest_to_json(test::sample_manifest()); }

std::string refusal(const json& document) {
  try {
    (void)manifest_from_json(document);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
    return error.what();
  }
  return {};
}

std::string refusal_of_text(const std::string& text) {
  try {
    (void)manifest_from_text(text);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
    return error.what();
  }
  return {};
}

/// Every object of `document` that a schema describes with fixed keys.
std::vector<json::json_pointer> objects(const json& document) {
  std::vector<json::json_pointer> found{json::json_pointer("")};
  for (const char* path :
       {"/source", "/material", "/structures/0", "/structures/1", "/items/0", "/items/1"}) {
    found.emplace_back(path);
    EXPECT_TRUE(document.contains(found.back()));
  }
  return found;
}

TEST(Manifest, ComesBackFromItsText) {
  const json document = sample();
  EXPECT_EQ(manifest_to_json(manifest_from_text(json_text(document))), document);
  const Manifest back = manifest_from_json(document);
  const Manifest made = test::sample_manifest();
  EXPECT_EQ(back.workspace_from_lps.matrix(), made.workspace_from_lps.matrix());
  EXPECT_EQ(back.source_lps_from_index.matrix(), made.source_lps_from_index.matrix());
  EXPECT_EQ(back.frame_times_s, made.frame_times_s);
  EXPECT_EQ(back.items[1].bytes, 99U);
  EXPECT_EQ(back.phase_count(), 3);
}

TEST(Manifest, WritesMatricesRowByRow) {
  const json document = sample();
  EXPECT_EQ(document["workspace_from_lps"].size(), 16U);
  EXPECT_EQ(document["workspace_from_lps"][3], 12.5);
  EXPECT_EQ(document["workspace_from_lps"][7], -3);
  EXPECT_EQ(document["workspace_from_lps"][15], 1);
}

TEST(Manifest, WithoutAnyOneKeyIsRefusedByItsPath) {
  const json whole = sample();
  for (const auto& pointer : objects(whole)) {
    for (const auto& member : whole[pointer].items()) {
      if (member.key() == "band") continue;  // what is not known is not told
      json document = whole;
      document[pointer].erase(member.key());
      const std::string path = (pointer / member.key()).to_string();
      EXPECT_NE(refusal(document).find(path), std::string::npos) << path << refusal(document);
    }
  }
}

TEST(Manifest, WithAnUnknownKeyIsRefusedByItsPath) {
  for (const auto& pointer : objects(sample())) {
    json document = sample();
    document[pointer]["surprise"] = 1;
    const std::string path = (pointer / "surprise").to_string();
    EXPECT_NE(refusal(document).find(path), std::string::npos) << path << refusal(document);
  }
}

/// The schema's keys at a place are the reader's keys there, which the two tests above hold to be
/// those that to_json writes.
void compare_keys(const json& schema, const json& document, const std::string& path) {
  if (schema.contains("properties")) {
    std::vector<std::string> described;
    std::vector<std::string> written;
    for (const auto& member : schema["properties"].items()) {
      const bool optional = member.key() == "level" || member.key() == "band";
      if (optional && !document.contains(member.key())) continue;
      described.push_back(member.key());
      if (document.contains(member.key())) {
        compare_keys(member.value(), document[member.key()], path + "/" + member.key());
      }
    }
    for (const auto& member : document.items()) written.push_back(member.key());
    EXPECT_EQ(described, written) << "at " << path;
    std::vector<std::string> required = schema["required"];
    if (schema.contains("then")) {
      for (const json& key : schema["then"]["required"]) required.push_back(key);
    }
    for (const char* optional : {"level", "band"}) {
      if (document.contains(optional)) required.emplace_back(optional);
    }
    std::sort(required.begin(), required.end());
    EXPECT_EQ(required, written) << "at " << path;
    EXPECT_EQ(schema["additionalProperties"], false) << "at " << path;
  } else if (schema.contains("items") && document.is_array()) {
    for (const json& entry : document) compare_keys(schema["items"], entry, path + "/*");
  }
}

TEST(Manifest, HasTheKeysOfItsSchemaAndNoOthers) {
  const json schema = test::json_file(std::string(BEATLAS_SCHEMAS) + "/manifest.schema.json");
  EXPECT_EQ(schema["properties"]["format_version"]["enum"],
            json::array({kOldestFormatVersion, 4, 5, 6, kFormatVersion}));
  compare_keys(schema, sample(), "");
}

TEST(Manifest, OutOfRangeIsRefusedByItsPath) {
  const std::vector<std::pair<const char*, json>> wrong{
      {"/format", "zip"},
      {"/format_version", 0},
      {"/format_version", "1"},
      {"/format_version", 1.5},
      {"/scene", "everything"},
      {"/rr_interval_s", 0},
      {"/rr_interval_s", -0.9},
      {"/rr_interval_s", nullptr},
      {"/rr_interval_s", std::numeric_limits<double>::quiet_NaN()},
      {"/frame_times_s", json::array()},
      {"/frame_times_s/1", "0.1"},
      {"/frame_times_s/1", 1e9},
      {"/workspace_from_lps/0", 2},   // stretches
      {"/workspace_from_lps/14", 1},  // projects
      {"/source/size/2", 1.5},
      {"/source/size/0", -1},
      {"/source/size", json::array({1, 2})},
      {"/source/lps_from_index/4", std::numeric_limits<double>::infinity()},
      {"/material/stiffness_n_per_m", -1},
      {"/end_diastole", 3},
      {"/end_systole", -1},
      {"/structures", json::array()},
      {"/structures/1/name", "liver"},
      {"/structures/1/name", "heart"},
      {"/structures/1/volume_ml", json::array({1, 2})},
      {"/structures/1/volume_ml/0", -1},
      {"/items/0/path", "surfaces/heart.motion"},
      {"/items/0/path", "../surfaces/heart.drc"},
      {"/items/0/kind", "texture"},
      {"/items/0/structure", "rv_blood"},
      {"/items/0/bytes", -1},
      {"/items/0/bytes", 1.5},
      {"/items/0/sha256", "abc"},
      {"/items/0/sha256", std::string(64, 'A')},
      {"/provenance", json::array()},
  };
  for (const auto& [path, value] : wrong) {
    json document = sample();
    document[json::json_pointer(path)] = value;
    // Entries of a matrix or size are refused by the path of the whole.
    std::string named = path;
    if (named.find("/workspace") == 0 || named.find("/source/") == 0) {
      named = named.substr(0, named.find_first_of("0123456789") - 1);
    }
    if (named == "/items/0/structure") named = "/items/0/path";
    if (value.is_string() && value == "surfaces/heart.motion") named = "/items/0/path";
    const std::string message = refusal(document);
    EXPECT_NE(message.find(named), std::string::npos) << path << " " << value << ": " << message;
  }
}

TEST(Manifest, OfANewerFormatIsRefusedByNumberBeforeAnythingElse) {
  const json future{{"format", "beatlas"}, {"format_version", 8}, {"scenes", json::array()}};
  EXPECT_NE(refusal(future).find("format version 8 is newer"), std::string::npos);
  const json far{{"format", "beatlas"}, {"format_version", 18446744073709551615ULL}};
  EXPECT_NE(refusal(far).find("newer"), std::string::npos);
}

TEST(Manifest, WithAnItemOfAStructureItDoesNotListIsRefused) {
  json document = sample();
  document["items"][0]["structure"] = "rv_blood";
  document["items"][0]["path"] = "surfaces/rv_blood.drc";
  EXPECT_NE(refusal(document).find("/items/0/structure"), std::string::npos);
  document = sample();
  document["items"][1] = document["items"][0];
  EXPECT_NE(refusal(document).find("/items/1/path"), std::string::npos);
}

TEST(Manifest, HasAVolumeOfTheHeartAlone) {
  json document = sample();
  json& item = document["items"][0];
  item["kind"] = "volume";
  item["path"] = "volumes/heart.volume.zst";
  EXPECT_EQ(refusal(document), "");
  item["structure"] = "lv_blood";
  item["path"] = "volumes/lv_blood.volume.zst";
  EXPECT_NE(refusal(document).find("/items/0/structure"), std::string::npos);
}

TEST(Manifest, HasMapsOfTheVentriclesWallsAloneAndNotBeforeTheirVersions) {
  json document = sample();
  json& item = document["items"][0];
  item["kind"] = "surface_map";
  item["structure"] = "lv_blood";
  item["path"] = "maps/lv_blood.map.zst";
  EXPECT_EQ(refusal(document), "");
  json old = document;
  old["format_version"] = 3;
  old["structures"][0].erase("band");
  old.erase("surface_edges_mm");
  EXPECT_NE(refusal(old).find("/items/0/kind"), std::string::npos);
  item["structure"] = "rv_blood";
  item["path"] = "maps/rv_blood.map.zst";
  document["structures"].push_back(document["structures"][0]);
  document["structures"].back()["name"] = "rv_blood";
  document["structures"].back().erase("band");
  EXPECT_EQ(refusal(document), "");
  old = document;
  old["structures"][0].erase("band");
  old["format_version"] = 5;
  EXPECT_NE(refusal(old).find("/items/0/structure must be lv_blood or lv_myocardium before"),
            std::string::npos);
  item["structure"] = "heart";
  item["path"] = "maps/heart.map.zst";
  EXPECT_NE(refusal(document).find("/items/0/structure"), std::string::npos);
}

TEST(Manifest, HasLevelsOfSurfacesAloneAndNotBeforeVersion5) {
  json document = sample();
  document["surface_edges_mm"] = {2, 4.5};
  document["items"].erase(2);
  json& item = document["items"][0];
  item["level"] = 1;
  EXPECT_NE(refusal(document).find("/items/0/path"), std::string::npos);
  item["path"] = "surfaces/heart.level1.drc";
  EXPECT_EQ(refusal(document), "");
  const Manifest manifest = manifest_from_json(document);
  EXPECT_EQ(manifest.surface_edges_mm, (std::vector<double>{2, 4.5}));
  EXPECT_EQ(manifest.items[0].level, 1);
  EXPECT_TRUE(holds_surface(manifest, Structure::Heart, 1));
  EXPECT_FALSE(holds_surface(manifest, Structure::Heart, 0));
  EXPECT_EQ(manifest_to_json(manifest), document);
  for (const json& level : {json(0), json(-1), json(8), json("1"), json(1.5)}) {
    item["level"] = level;
    EXPECT_NE(refusal(document).find("/items/0/level"), std::string::npos) << level;
  }
  item["level"] = 2;
  item["path"] = "surfaces/heart.level2.drc";
  EXPECT_NE(refusal(document).find("/items/0/level"), std::string::npos);
  item["level"] = 1;
  item["path"] = "surfaces/heart.level1.drc";
  for (const json& edges : {json{2, 2}, json{4, 2}, json{2, 0}, json{2, nullptr}, json("2"),
                            json{1, 2, 3, 4, 5, 6, 7, 8, 9}}) {
    json wrong = document;
    wrong["surface_edges_mm"] = edges;
    EXPECT_NE(refusal(wrong).find("/surface_edges_mm"), std::string::npos) << edges;
  }
  json old = document;
  old["structures"][0].erase("band");
  old["format_version"] = 4;
  EXPECT_NE(refusal(old), "");
  old.erase("surface_edges_mm");
  EXPECT_NE(refusal(old).find("/items/0/level"), std::string::npos);
  item["kind"] = "field";
  item["path"] = "fields/heart.field.zst";
  EXPECT_NE(refusal(document).find("/items/0/level"), std::string::npos);
}

TEST(Manifest, HasBandsOfTheSourcesSlicesAndNotBeforeVersion7) {
  const json document = sample();
  EXPECT_EQ(manifest_to_json(manifest_from_json(document)), document);
  const auto refused = [&](const char* at, const json& wrong) {
    json changed = document;
    changed["structures"][0]["band"][json::json_pointer(at)] = wrong;
    return refusal(changed);
  };
  const json slices = document["structures"][0]["band"]["across_mm"][0];
  json fewer = slices;
  fewer.erase(0);
  EXPECT_NE(refused("/across_mm/1", fewer).find("/structures/0/band/across_mm/1 must be a list"),
            std::string::npos);
  EXPECT_NE(refused("/along_mm", {slices, slices}).find("/structures/0/band/along_mm must be a"),
            std::string::npos);
  for (const json& wrong : {json(-0.1), json(1000.5), json("2"), json(nullptr)}) {
    EXPECT_NE(refused("/across_mm/2/10", wrong).find("/structures/0/band/across_mm/2/10 must be"),
              std::string::npos);
  }
  EXPECT_NE(refused("/known", 1).find("known"), std::string::npos);
  json without = document;
  without["structures"][0]["band"].erase("along_mm");
  EXPECT_NE(refusal(without).find("along_mm"), std::string::npos);
  json old = document;
  old["format_version"] = 6;
  EXPECT_NE(refusal(old).find("/structures/0/band is not of this format version"),
            std::string::npos);
  json of_no_images = document;
  of_no_images["source"]["size"] = {0, 0, 0};
  EXPECT_NE(refusal(of_no_images).find("/structures/0/band must not be there"), std::string::npos);
}

TEST(Manifest, OfTextThatIsNoStrictJsonIsRefused) {
  const std::string good = json_text(sample());
  EXPECT_EQ(refusal_of_text(good), "");
  EXPECT_NE(refusal_of_text(""), "");
  EXPECT_NE(refusal_of_text("[]"), "");
  EXPECT_NE(refusal_of_text("\xff\xfe"), "");
  EXPECT_NE(refusal_of_text(good + "{}"), "");
  EXPECT_NE(refusal_of_text(good.substr(0, good.size() - 1)), "");
  EXPECT_NE(refusal_of_text(R"({"format": "beatlas", "format": "beatlas"})").find("twice"),
            std::string::npos);
  std::string huge = good;
  huge.replace(huge.find("0.875"), 5, "1e999");
  EXPECT_NE(refusal_of_text(huge), "");
  EXPECT_NE(refusal_of_text(std::string(100000, '[')).find("nested"), std::string::npos);
  EXPECT_NE(refusal_of_text(std::string(100000, '{')), "");
}

}  // namespace
}  // namespace beatlas::atlas
