#include "runtime/app/exercise_files.h"

#include <filesystem>
#include <functional>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "runtime/base/error.h"
#include "runtime/base/json_text.h"

namespace beatlas::app {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

KeptSession played() {
  KeptSession out;
  out.exercise.title = "Find it";
  out.package = "heart.beatlas";
  out.seed = std::uint64_t{1} << 53U;
  out.heart_rate_per_min = 72.5;
  out.trials = {{.parts = {part_name(0, 0), part_name(0, 1)}, .played_s = 12.5, .done = true}};
  return out;
}

/// What is said of a session that `change` was made to.
std::string refusal(const std::function<void(json&)>& change) {
  json document = parse_json(kept_session_text(played()));
  change(document);
  try {
    (void)kept_session_from_text(json_text(document), "session.json");
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
    return error.what();
  }
  return "";
}

TEST(KeptSession, IsReadAsItWasWritten) {
  const std::string text = kept_session_text(played());
  const KeptSession read = kept_session_from_text(text, "session.json");
  EXPECT_EQ(kept_session_text(read), text);
  EXPECT_EQ(read.seed, played().seed);
  EXPECT_EQ(read.trials.front().parts.back(), "trial_001_2.csv");
  EXPECT_TRUE(read.finished());
}

TEST(KeptSession, WhatCannotBeIsRefusedByItsFileAndPlace) {
  EXPECT_EQ(refusal([](json&) {}), "");
  const json sound = parse_json(kept_session_text(played()));
  for (const auto& item : sound.items()) {
    EXPECT_EQ(refusal([&](json& s) { s.erase(item.key()); }),
              "session.json: /" + item.key() + " is missing");
  }
  for (const auto& item : sound["trials"][0].items()) {
    EXPECT_EQ(refusal([&](json& s) { s["trials"][0].erase(item.key()); }),
              "session.json: /trials/0/" + item.key() + " is missing");
  }
  EXPECT_EQ(refusal([](json& s) { s["seed"] = 0.5; }),
            "session.json: /seed must be a whole number");
  EXPECT_TRUE(refusal([](json& s) { s["seed"] = -1; }).starts_with("session.json: /seed must be"));
  EXPECT_EQ(refusal([](json& s) {
              s["exercise"]["grade"] = {0.5, 0.9};
            }),
            "session.json: /exercise/grade must end at 0.7 or before where a lesion may be soft or "
            "thin");
  EXPECT_TRUE(refusal([](json& s) {
                s["exercise"]["preset"] = "fever";
              }).starts_with("session.json: /exercise/preset must be"));
  EXPECT_TRUE(refusal([](json& s) {
                s["exercise"]["task"] = "search";
              }).starts_with("session.json: /exercise/task must be"));
  EXPECT_TRUE(refusal([](json& s) {
                s["exercise"]["lesions"] = 4;
              }).starts_with("session.json: /exercise/lesions must be"));
  EXPECT_EQ(refusal([](json& s) { s["exercise"] = 1; }),
            "session.json: /exercise must be a JSON object");
  EXPECT_EQ(refusal([](json& s) { s["trials"][0]["parts"][0] = "../../other.csv"; }),
            "session.json: /trials/0/parts/0 must be trial_001_1.csv");
  EXPECT_EQ(refusal([](json& s) { s = nullptr; }), "session.json: / must be a JSON object");
  EXPECT_THROW((void)kept_session_from_text("{} // nothing", "session.json"), Error);
}

TEST(KeptSession, AFolderInPlaceOfAFileIsRefused) {
  const fs::path folder =
      fs::temp_directory_path() / ("beatlas_exercise_files_" + std::to_string(::getpid()));
  fs::create_directories(folder / "session.json");
  fs::create_directories(folder / part_name(0, 0));
  const auto said = [](const std::function<void()>& read) -> std::string {
    try {
      read();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(said([&] { (void)read_session(folder); }),
            (folder / "session.json").string() + " cannot be read; check its name and rights");
  EXPECT_EQ(said([&] { (void)read_parts(folder, {.parts = {part_name(0, 0)}}); }),
            (folder / part_name(0, 0)).string() + " cannot be read; check its name and rights");
  fs::remove_all(folder);
}

}  // namespace
}  // namespace beatlas::app
