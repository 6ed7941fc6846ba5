#include "runtime/base/nearest_name.h"

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "runtime/base/json_object.h"

namespace beatlas {
namespace {

const std::set<std::string> kNames{"edge_mm", "handles", "outer_mm", "inner_mm", "reference_phase"};

TEST(NearestName, IsTheOneThatWasMistyped) {
  for (const auto& [word, meant] :
       {std::pair("egde_mm", "edge_mm"),  // swapped
        std::pair("handels", "handles"), std::pair("iner_mm", "inner_mm"),
        std::pair("outter_mm", "outer_mm"), std::pair("EdgeMm", "edge_mm"),
        std::pair("edge-mm", "edge_mm"), std::pair("edge", "edge_mm"),
        std::pair("reference", "reference_phase")}) {
    EXPECT_EQ(nearest_name(word, kNames), meant) << word;
  }
}

TEST(NearestName, IsNoneWhereNothingIsNear) {
  for (const char* word : {"colour", "mm", "x", "", "___", "threads"}) {
    EXPECT_EQ(nearest_name(word, kNames), "") << word;
  }
  EXPECT_EQ(nearest_name(std::string(100000, 'e'), kNames), "");
  EXPECT_EQ(nearest_name("edge", {}), "");
}

std::string refusal(const nlohmann::json& value) {
  JsonObject object(value, "/mesh");
  double edge_mm = 2;
  object.read("edge_mm", edge_mm, 0.5, 10);
  // Asked for and not there: it is a known name all the same.
  if (object.has("handles")) (void)object.at("handles");
  try {
    object.finish();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(JsonObject, NamesTheNearestOfTheKeysItWasAskedFor) {
  EXPECT_EQ(refusal({{"edge_mm", 3}, {"handels", "keep"}}),
            "/mesh/handels is not a known key; did you mean handles?");
  EXPECT_EQ(refusal({{"colour", "red"}}),
            "/mesh/colour is not a known key; known are edge_mm, handles");
  EXPECT_EQ(refusal({{"handles", "keep"}}), "");
}

}  // namespace
}  // namespace beatlas
