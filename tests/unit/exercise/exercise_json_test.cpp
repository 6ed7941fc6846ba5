#include <filesystem>
#include <fstream>
#include <iterator>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "runtime/base/error.h"
#include "runtime/base/json_text.h"
#include "runtime/exercise/exercise.h"

namespace beatlas::exercise {
namespace {

using nlohmann::json;

std::string refusal(json document) {
  document["version"] = 1;
  try {
    (void)exercise_from_json(document);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(ExerciseJson, SamplesAreReadAndWrittenAsTheyWere) {
  int count = 0;
  for (const auto& file :
       std::filesystem::directory_iterator(BEATLAS_SOURCE_DIR "/samples/exercises")) {
    std::ifstream stream(file.path());
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    const json document = parse_json(text, JsonComments::Skip);
    ASSERT_FALSE(document.is_discarded()) << file.path();
    const json written = exercise_to_json(exercise_from_json(document));
    for (const auto& item : document.items()) {
      EXPECT_EQ(written.at(item.key()), item.value()) << file.path() << " " << item.key();
    }
    EXPECT_EQ(exercise_to_json(exercise_from_json(written)), written);
    ++count;
  }
  EXPECT_EQ(count, 10);
}

TEST(ExerciseJson, WhatCannotBeIsRefusedByItsPlace) {
  EXPECT_EQ(refusal(json::object()), "");
  EXPECT_NE(refusal({{"task", "search"}}).find("/task must be"), std::string::npos);
  EXPECT_NE(refusal({{"kinds", {"soft", "hard"}}}).find("/kinds/1 is none of soft, thin"),
            std::string::npos);
  EXPECT_NE(refusal({{"kinds", {"soft", "soft"}}}).find("/kinds/1 is there twice"),
            std::string::npos);
  EXPECT_NE(refusal({{"kinds", json::array()}}).find("/kinds must be"), std::string::npos);
  EXPECT_NE(refusal({{"segments", {"mid_anterior", "left"}}}).find("/segments/1"),
            std::string::npos);
  EXPECT_NE(refusal({{"radius_mm", {12, 8}}}).find("/radius_mm must be two"), std::string::npos);
  EXPECT_NE(refusal({{"radius_mm", {8, 80}}}).find("/radius_mm"), std::string::npos);
  EXPECT_NE(refusal({{"grade", {0.5, 0.9}}}).find("/grade must end at 0.7"), std::string::npos);
  EXPECT_EQ(refusal({{"kinds", {"scar"}}, {"grade", {0.5, 0.9}}}), "");
  EXPECT_NE(refusal({{"lesions", 4}}).find("/lesions"), std::string::npos);
  EXPECT_NE(refusal({{"preset", "fever"}}).find("/preset"), std::string::npos);
  EXPECT_NE(refusal({{"task", "threshold"}, {"kinds", {"soft"}}}).find("/kinds"),
            std::string::npos);
  EXPECT_NE(refusal({{"trials", 40}}).find("/trials"), std::string::npos);
  EXPECT_NE(refusal({{"task", "threshold"}, {"places", 1}}).find("/places"), std::string::npos);
}

}  // namespace
}  // namespace beatlas::exercise
