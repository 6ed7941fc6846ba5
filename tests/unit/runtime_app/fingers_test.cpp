// Several devices on one heart, against its closed form.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "runtime/base/json_text.h"
#include "runtime/device/csv_table.h"
#include "tests/unit/runtime_app/played_ellipsoid.h"

namespace beatlas::app {
namespace {

using namespace test;

struct FingerTrace {
  std::vector<Vec3> force_n;
  std::vector<double> depth_mm;
};

FingerTrace trace_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  FingerTrace out;
  for (const std::vector<double>& row :
       device::read_csv(stream, file.string(), {"fx_n", "fy_n", "fz_n", "depth_mm"}).rows) {
    out.force_n.emplace_back(row[0], row[1], row[2]);
    out.depth_mm.push_back(row[3]);
  }
  return out;
}

std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::string fingers_file(const nlohmann::json& fingers) {
  const std::filesystem::path file = folder() / "fingers.json";
  std::ofstream(file) << nlohmann::json{{"version", 1}, {"fingers", fingers}};
  return file.string();
}

// A finger on either side of the ellipsoid: what one takes the other gives, and both feel the beat,
// whose walls move by 1.5 mm up and down.
TEST(Fingers, OnOppositeWallsHoldTheHeartAndFeelItsPulse) {
  const std::string fingers =
      fingers_file({{{"side", "left"}, {"hand", "still"}}, {{"side", "right"}, {"hand", "still"}}});
  const Result both =
      run({package(), "--headless", "--fast", "--seconds", "4", "--tool-radius-mm", "3",
           "--fingers", fingers, "--json", "--trace", (folder() / "both.csv").string()});
  ASSERT_EQ(both.code, 0) << both.err;
  const nlohmann::json reports = parse_json(both.out)["fingers"];
  ASSERT_EQ(reports.size(), 2U);
  for (const nlohmann::json& report : reports) {
    EXPECT_EQ(report["ticks"], 4000);
    EXPECT_EQ(report["faults"], 0);
    EXPECT_EQ(report["contact_share"], 1);
  }
  const FingerTrace left = trace_of(folder() / "both_1.csv");
  const FingerTrace right = trace_of(folder() / "both_2.csv");
  ASSERT_EQ(left.force_n.size(), right.force_n.size());
  double least = 1e9;
  double most = 0;
  double sum = 0;
  for (std::size_t n = 1000; n < left.force_n.size(); ++n) {  // behind the start ramp
    least = std::min(least, left.force_n[n].norm());
    most = std::max(most, left.force_n[n].norm());
    sum = std::max(sum, (left.force_n[n] + right.force_n[n]).norm());
  }
  const double pulse_n = 0.18 * 3;
  EXPECT_NEAR(most - least, pulse_n, 0.1 * pulse_n);
  EXPECT_LT(sum, 0.1 * pulse_n);

  // A finger feels beside another what it feels alone.
  const Result alone =
      run({package(), "--headless", "--fast", "--seconds", "4", "--tool-radius-mm", "3", "--side",
           "right", "--hand", "still", "--trace", (folder() / "alone.csv").string()});
  ASSERT_EQ(alone.code, 0) << alone.err;
  EXPECT_EQ(text_of(folder() / "alone.csv"), text_of(folder() / "both_2.csv"));
}

// Two hands that the force moves, 300 N/m, 60 beats: what is left of the start dies away and does
// not come back.
TEST(Fingers, HandsHoldAStiffHeartForSixtyBeats) {
  const nlohmann::json hand{{"hand", "still"}, {"mass_kg", 0.15}, {"depth_mm", 5}};
  nlohmann::json left = hand;
  nlohmann::json right = hand;
  left["side"] = "left";
  right["side"] = "right";
  const Result held =
      run({(folder() / "stiff.beatlas").string(), "--headless", "--fast", "--seconds", "48",
           "--tool-radius-mm", "3", "--fingers", fingers_file({left, right}), "--trace",
           (folder() / "held.csv").string()});
  ASSERT_EQ(held.code, 0) << held.err;
  for (const char* name : {"held_1.csv", "held_2.csv"}) {
    const FingerTrace trace = trace_of(folder() / name);
    ASSERT_EQ(trace.force_n.size(), 48000U);
    const auto swing = [&](std::size_t from, std::size_t to) {
      double least = 1e9;
      double most = 0;
      for (std::size_t n = from; n < to; ++n) {
        least = std::min(least, trace.force_n[n].norm());
        most = std::max(most, trace.force_n[n].norm());
      }
      return most - least;
    };
    const double early = swing(8000, 16000);  // beats 11 to 20
    const double late = swing(40000, 48000);
    EXPECT_GT(late, 0.05) << "the pulse is felt";
    EXPECT_NEAR(late, early, 0.01 * early);
    EXPECT_GT(*std::min_element(trace.depth_mm.begin() + 8000, trace.depth_mm.end()), 0);
  }
}

TEST(Fingers, TheSampleOfThreeRuns) {
  const Result result = run({package(), "--headless", "--fast", "--seconds", "1", "--fingers",
                             BEATLAS_SOURCE_DIR "/samples/fingers.json"});
  EXPECT_EQ(result.code, 0) << result.err;
  for (const char* words : {"finger 1: simulated device: 1000 ticks", "finger 2:", "finger 3:"}) {
    EXPECT_NE(result.out.find(words), std::string::npos) << result.out;
  }
}

TEST(Fingers, WhatMakesNoSenseIsRefusedByItsPlace) {
  const auto refused = [](const nlohmann::json& fingers, const std::string& words,
                          std::vector<std::string> more = {"--fast"}) {
    std::vector<std::string> all{package(), "--headless", "--seconds",
                                 "0.1",     "--fingers",  fingers_file(fingers)};
    all.insert(all.end(), more.begin(), more.end());
    const Result result = run(all);
    EXPECT_NE(result.code, 0);
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
  };
  const nlohmann::json plain = nlohmann::json::object();
  refused({plain}, "/fingers must be a list of two to eight");
  refused({plain, {{"side", "inside"}}}, "/fingers/1/side must be one of left");
  refused({plain, {{"device", "replay"}}}, "/fingers/1: device replay and a recording");
  refused({{{"depth_mm", 500}}, plain}, "/fingers/0/depth_mm");
  refused({plain, {{"finger", 2}}}, "/fingers/1/finger");
  refused({plain, {{"device", "replay"}, {"recording", "none.csv"}}}, "none.csv");
  refused({{{"device", "dhd"}}, {{"device", "dhd"}}}, "tell them apart by device_name", {});
  refused({{{"device", "dhd"}}, plain}, "leave --fast out");
  refused({plain, plain}, "--heart-rate must be from 30 to 220",
          {"--fast", "--model", "patch", "--heart-rate", "20"});
  refused({plain, plain}, "leave --exercise, --ticks and --recording out",
          {"--fast", "--ticks", (folder() / "t").string()});
  std::ofstream(folder() / "fingers.json") << "{";
  const Result broken =
      run({package(), "--headless", "--fingers", (folder() / "fingers.json").string()});
  EXPECT_EQ(broken.code, 3);
  EXPECT_NE(broken.err.find("is not valid JSON"), std::string::npos);
}

}  // namespace
}  // namespace beatlas::app
