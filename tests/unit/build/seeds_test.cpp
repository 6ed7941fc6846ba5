#include "pipeline/build/seeds.h"

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "runtime/base/json_text.h"

namespace beatlas::build {
namespace {
using nlohmann::json;

std::string refusal(const json& value) {
  try {
    (void)seeds_from_json(value);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
    return error.what();
  }
  ADD_FAILURE() << value << " was read";
  return {};
}

json ball() { return {{"label", 3}, {"lps_mm", {1.5, -2, 3}}}; }
json stroke() {
  return {{"label", 2}, {"stroke_lps_mm", {{0, 0, 1}, {5, 0, 1.25}, {5, 6, 1}}}, {"phase", 4}};
}

TEST(SeedsFile, KeepsBallsAndStrokesInTheOrderDrawn) {
  const auto seeds = seeds_from_json({{"version", 1}, {"seeds", {ball(), stroke(), ball()}}});
  ASSERT_EQ(seeds.size(), 3U);
  EXPECT_EQ(seeds[0].lps_mm, Vec3(1.5, -2, 3));
  EXPECT_TRUE(seeds[0].stroke_lps_mm.empty());
  EXPECT_EQ(seeds[0].radius_mm, segment::Seed{}.radius_mm);
  EXPECT_EQ(seeds[1].label, 2);
  EXPECT_EQ(seeds[1].phase, 4);
  EXPECT_EQ(seeds[1].lps_mm, Vec3(0, 0, 1));
  EXPECT_EQ(seeds[1].stroke_lps_mm, (std::vector<Vec3>{{5, 0, 1.25}, {5, 6, 1}}));
  EXPECT_TRUE(seeds[2].stroke_lps_mm.empty());
}

TEST(SeedsFile, ReadsBackWhatItWroteToTheLastBit) {
  segment::Seed odd{1, Vec3(0.1, -1.0 / 3, 1e-9), 0.3, -1, {Vec3(2.0 / 7, 4999.9, -0.7)}};
  const json written = seeds_to_json({{3, Vec3(0.2, 0.3, 0.6), 2.5, 7, {}}, odd});
  EXPECT_EQ(written.at("version"), 1);
  const auto seeds = seeds_from_json(parse_json(json_text(written)));
  ASSERT_EQ(seeds.size(), 2U);
  EXPECT_EQ(seeds[1].lps_mm, odd.lps_mm);
  EXPECT_EQ(seeds[1].stroke_lps_mm, odd.stroke_lps_mm);
  EXPECT_EQ(seeds[1].radius_mm, odd.radius_mm);
  EXPECT_EQ(seeds_to_json(seeds), written);
}

TEST(SeedsFile, WithoutAVersionIsOfTheFirstAndOthersAreRefusedByTheirNumber) {
  EXPECT_EQ(seeds_from_json({{"seeds", {ball()}}}).size(), 1U);
  const std::string said = refusal({{"version", 2}, {"seeds", {ball()}}});
  EXPECT_NE(said.find("version is 2"), std::string::npos) << said;
  EXPECT_NE(said.find("version 1"), std::string::npos) << said;
  EXPECT_NE(refusal({{"version", "1"}, {"seeds", {ball()}}}).find("/version"), std::string::npos);
}

TEST(SeedsFile, NamesWhatIsWrongWithAStroke) {
  const auto with = [](const std::string& key, const json& value) {
    json seed = stroke();
    seed[key] = value;
    return json{{"seeds", {seed}}};
  };
  const std::string path = "/seeds/0/stroke_lps_mm";
  EXPECT_NE(refusal(with("stroke_lps_mm", {{0, 0, 1}})).find(path + " must"), std::string::npos);
  EXPECT_NE(refusal(with("stroke_lps_mm", {{0, 0, 1}, {0, 1}})).find(path + "/1"),
            std::string::npos);
  EXPECT_NE(refusal(with("stroke_lps_mm", {{0, 0, 1}, {0, 1, 5001}})).find(path + "/1"),
            std::string::npos);
  EXPECT_NE(refusal(with("lps_mm", {0, 0, 1})).find("either"), std::string::npos);
  json neither = stroke();
  neither.erase("stroke_lps_mm");
  EXPECT_NE(refusal({{"seeds", {neither}}}).find("either"), std::string::npos);
}

}  // namespace
}  // namespace beatlas::build
