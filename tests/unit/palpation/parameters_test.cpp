#include "runtime/palpation/parameters.h"

#include <string>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "runtime/base/json_text.h"
#include "runtime/palpation/on_heart.h"
#include "tests/json_file.h"

namespace beatlas::palpation {
namespace {

using nlohmann::json;

json file(const std::string& name) {
  return test::json_file(std::string(BEATLAS_SOURCE_DIR) + name, JsonComments::Skip);
}

std::string refusal(const json& document) {
  try {
    (void)palpation_from_json(document);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
    return error.what();
  }
  return "";
}

TEST(PalpationParameters, TheSampleHoldsTheDefaults) {
  // Table 1 as printed is data: the file says the same as the structs.
  EXPECT_EQ(palpation_to_json(palpation_from_json(file("/samples/palpation.json"))),
            palpation_to_json(PalpationParameters{}));
  EXPECT_EQ(palpation_to_json(palpation_from_json(json::object())),
            palpation_to_json(PalpationParameters{}));
}

TEST(PalpationParameters, ComeBackFromTheirJson) {
  for (const std::string& name : palpation_presets()) {
    const json once = palpation_to_json(palpation_preset(name));
    EXPECT_EQ(palpation_to_json(palpation_from_json(once)), once) << name;
  }
}

TEST(PalpationParameters, AreRefusedByTheirPathWithTheRange) {
  const auto says = [](const char* text, const std::string& path, const std::string& range) {
    const std::string message = refusal(parse_json(text));
    EXPECT_NE(message.find(path), std::string::npos) << message;
    EXPECT_NE(message.find(range), std::string::npos) << message;
  };
  says(R"({"muscle": {"apex": {"k_v_n_per_m": -45}}})", "/muscle/apex/k_v_n_per_m", "to 100000");
  says(R"({"muscle": {"wall_mass_kg": "1"}})", "/muscle/wall_mass_kg", "0 to 10");
  says(R"({"muscle": {"contact_n_per_m": 120}})", "/muscle/contact_n_per_m", "from 335.");
  says(R"({"circulation": {"emin_mmhg_per_ml": 5}})", "/circulation/emin_mmhg_per_ml", "4.5");
  says(R"({"circulation": {"heart_rate_per_min": 300}})", "/circulation/heart_rate_per_min",
       "30 to 220");
  says(R"({"circulation": {"v0_ml": 60}})", "/circulation/reference_volume_ml", "60");
  says(R"({"circulation": {"contact": "soft"}})", "/circulation/contact", "kinematic");
  says(R"({"circulation": {"aortic_target_mmhg": 5}})", "/circulation/aortic_target_mmhg", "20");
  says(R"({"segments": {"mid_anterior": {"alpha": 1.5}}})", "/segments/mid_anterior/alpha",
       "0 to 1");
  says(R"({"segments": {"spleen": {"alpha": 1}}})", "/segments/spleen", "basal_anterior");
  says(R"({"segments": {"apex": {"colour": 1}}})", "/segments/apex/colour", "known key");
  says(R"({"muscle": {"middle": {"mass": 1}}})", "/muscle/middle/mass", "known key");
  says(R"({"version": 2})", "/version", "1");
  says(R"([])", "/", "object");
}

TEST(PalpationParameters, FollowTheirSchemaInEveryRange) {
  // What the schema says of a number is what the reader allows.
  const json schema = file("/schemas/palpation.schema.json");
  int tried = 0;
  const auto try_all = [&](const json& properties, auto wrap) {
    for (const auto& item : properties.items()) {
      const json& rule = item.value();
      if (!rule.contains("maximum")) continue;
      const double low = rule["minimum"];
      const double high = rule["maximum"];
      EXPECT_NE(refusal(wrap(item.key(), low - 1)), "") << item.key();
      EXPECT_NE(refusal(wrap(item.key(), 1.001 * high + 1)), "") << item.key();
      // Two numbers may not fit together; then another path than that of the range is named.
      EXPECT_EQ(refusal(wrap(item.key(), high)).find(item.key() + " must be a number"),
                std::string::npos);
      EXPECT_EQ(refusal(wrap(item.key(), low)).find(item.key() + " must be a number"),
                std::string::npos);
      ++tried;
    }
  };
  const json& sections = schema["properties"];
  try_all(sections["circulation"]["properties"], [](const std::string& key, double v) {
    return json{{"circulation", {{key, v}}}};
  });
  try_all(sections["muscle"]["properties"], [](const std::string& key, double v) {
    return json{{"muscle", {{key, v}}}};
  });
  try_all(schema["$defs"]["place"]["properties"], [](const std::string& key, double v) {
    return json{{"muscle", {{"base", {{key, v}}}}}};
  });
  try_all(schema["$defs"]["tissue"]["properties"], [](const std::string& key, double v) {
    return json{{"segments", {{"apex", {{key, v}}}}}};
  });
  EXPECT_EQ(tried, 20 + 2 + 5 + 4);
  // And every key that is written is in the schema.
  const json written = palpation_to_json(palpation_preset("anterior_infarct"));
  for (const auto& section : written.items()) {
    ASSERT_TRUE(sections.contains(section.key()));
    if (!section.value().is_object()) continue;
    for (const auto& item : section.value().items()) {
      EXPECT_TRUE(sections[section.key()]["properties"].contains(item.key())) << item.key();
    }
  }
}

TEST(PalpationParameters, PresetsAreThereByName) {
  for (const std::string& name : palpation_presets()) {
    EXPECT_NO_THROW((void)palpation_preset(name)) << name;
  }
  EXPECT_THROW((void)palpation_preset("spleen"), Error);
  const auto infarct = palpation_preset("anterior_infarct").whole_circulation();
  EXPECT_NEAR(infarct.infarct_fraction, 4 * 0.35 / 6 + 3 * 0.06, 1e-12);
  EXPECT_NEAR(infarct.infarct_alpha, 0.2, 1e-12);
  // by_74_percent: same integrator, another contact area and nothing else.
  json healthy = palpation_to_json(PalpationParameters{});
  json by_74 = palpation_to_json(palpation_preset("by_74_percent"));
  EXPECT_EQ(by_74["circulation"]["contact_area_cm2"], 41.3);
  healthy["circulation"].erase("contact_area_cm2");
  by_74["circulation"].erase("contact_area_cm2");
  EXPECT_EQ(healthy, by_74);
}

// Every lesson on hearts of every size and strength: from a child's to a dilated one's, and on one
// that ejects little.
TEST(PalpationParameters, EveryPresetGoesOnEveryHeart) {
  for (const double edv_ml : {60.0, 215.0, 350.0}) {
    for (const double ef : {0.28, 0.65}) {
      const HeartSize heart{
          .edv_ml = edv_ml, .esv_ml = edv_ml * (1 - ef), .heart_rate_per_min = 59};
      for (const std::string& preset : palpation_presets()) {
        SCOPED_TRACE(preset + " " + std::to_string(edv_ml) + " " + std::to_string(ef));
        double filled_ml = 0;
        EXPECT_NO_THROW(
            filled_ml = on_heart(palpation_preset(preset), heart).circulation.reference_volume_ml);
        if (preset == "healthy") {
          EXPECT_NEAR(filled_ml, edv_ml, 0.01 * edv_ml);
        } else if (preset == "low_pressure") {
          EXPECT_LT(filled_ml, 0.9 * edv_ml);
        }
      }
    }
  }
}

}  // namespace
}  // namespace beatlas::palpation
