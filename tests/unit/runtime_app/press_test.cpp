#include "runtime/app/press.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "runtime/app/play.h"
#include "runtime/base/error.h"
#include "runtime/base/json_text.h"
#include "runtime/palpation/fit.h"
#include "runtime/plot/plot.h"

namespace beatlas::app {
namespace {

struct Called {
  int code;
  std::string out;
  std::string err;
};

Called call(const std::vector<std::string>& words) {
  std::vector<const char*> argv{"beatlas-play"};
  for (const std::string& word : words) argv.push_back(word.c_str());
  std::istringstream in;
  std::ostringstream out;
  std::ostringstream err;
  const int code = play(static_cast<int>(argv.size()), argv.data(), in, out, err);
  return {code, out.str(), err.str()};
}

class Folder {
 public:
  Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() { std::filesystem::remove_all(path_); }
  [[nodiscard]] std::string file(const std::string& name) const { return (path_ / name).string(); }
  [[nodiscard]] std::string text(const std::string& name) const {
    std::ifstream stream(path_ / name);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

 private:
  std::filesystem::path path_ =
      std::filesystem::temp_directory_path() / ("beatlas_press_test_" + std::to_string(::getpid()));
};

TEST(Press, WaitsForWholeBeatsOfASlowHeart) {
  for (const double rate : {30.0, 45.0, 220.0}) {
    palpation::PalpationParameters parameters;
    parameters.circulation.heart_rate_per_min = rate;
    parameters.circulation.reference_volume_ml =
        palpation::natural_beat(parameters.whole_circulation()).edv_ml;
    const Press press = run_press(parameters, {});
    for (const auto* loop : {&press.natural, &press.pressed}) {
      EXPECT_NEAR(static_cast<double>(loop->size()), 60'000 / rate, 2) << rate;
    }
    // A beat before the finger comes, and the last one under it.
    EXPECT_LT(press.natural.back().time_s, press.script.natural_s + 1e-9) << rate;
    const double let_go_s = press.script.natural_s + press.script.moving_s + press.script.held_s;
    EXPECT_GT(press.pressed.back().time_s, let_go_s - 60 / rate - 2e-3) << rate;
    EXPECT_LT(press.pressed_beat.output_l_per_min, 0.9 * press.natural_beat.output_l_per_min)
        << rate;
  }
}

TEST(Press, FollowsItsScriptAndLowersTheOutput) {
  const Press press = run_press({}, {});
  EXPECT_NEAR(press.pressed_beat.output_l_per_min / press.natural_beat.output_l_per_min, 0.74,
              0.03);
  EXPECT_NEAR(press.natural_beat.edv_ml, 49.9, 0.2);
  double deepest = 0;
  double last = 0;
  double step = 0;
  for (const PressRow& row : press.rows) {
    deepest = std::max(deepest, row.displacement_mm);
    step = std::max(step, std::abs(row.displacement_mm - last));
    last = row.displacement_mm;
    EXPECT_GE(row.force_n, 0);
    // Figure 8: before and long after it there is no force.
    if (row.time_s < press.script.natural_s) {
      EXPECT_LT(row.force_n, 0.01);
    }
  }
  EXPECT_EQ(deepest, 8);
  EXPECT_EQ(last, 0);
  EXPECT_LT(step, 0.06);  // 8 mm on half a cosine of 0.25 s: 50 mm/s
  // Figure 7b: the loop moves to smaller volumes and lower pressures, and is narrower.
  const auto width = [](const std::vector<PressRow>& loop) {
    const auto [least, most] = std::minmax_element(
        loop.begin(), loop.end(),
        [](const PressRow& a, const PressRow& b) { return a.volume_ml < b.volume_ml; });
    return std::pair{least->volume_ml, most->volume_ml};
  };
  const auto [natural_low, natural_high] = width(press.natural);
  const auto [pressed_low, pressed_high] = width(press.pressed);
  EXPECT_LT(pressed_high, natural_high - 8);
  EXPECT_LT(pressed_low, natural_low - 4);
  EXPECT_LT(pressed_high - pressed_low, 0.8 * (natural_high - natural_low));
}

TEST(Press, TellsTissuesApartInSteps) {
  const std::vector<TissueForce> tissues = compare_tissues({});
  ASSERT_EQ(tissues.size(), 5U);
  EXPECT_EQ(tissues[0].with_wall.diastole_jnd, 0);
  const TissueForce& infarct = tissues[1];
  EXPECT_EQ(infarct.name, "infarct");
  EXPECT_GT(infarct.in_space.diastole_jnd, 2);
  EXPECT_GT(infarct.with_wall.diastole_jnd, 2);
  EXPECT_GT(infarct.with_wall.systole_jnd, infarct.with_wall.diastole_jnd);  // it does not contract
  EXPECT_LT(infarct.with_wall.systole_n, tissues[0].with_wall.systole_n);
  EXPECT_GT(tissues[0].with_wall.systole_n, 1.1 * tissues[0].with_wall.diastole_n);
}

TEST(Press, IsWrittenByTheCommandWithoutAPackage) {
  const Folder folder;
  const Called done = call({"--headless", "--scene", "palpation", "--press", folder.file("")});
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_NE(done.out.find("% of natural"), std::string::npos);
  for (const char* name : {"press.svg", "loops.svg", "tissues.svg"}) {
    const std::string svg = folder.text(name);
    EXPECT_EQ(svg.rfind("<svg", 0), 0U) << name;
    EXPECT_NE(svg.find("</svg>"), std::string::npos) << name;
    EXPECT_EQ(svg.find("nan"), std::string::npos) << name;
  }
  const std::string csv = folder.text("press.csv");
  EXPECT_EQ(csv.rfind("t_s,displacement_mm,depth_mm,dent_mm,force_n,", 0), 0U);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 16501);
  EXPECT_NE(folder.text("loops.csv").find("\npressed,"), std::string::npos);
  const auto report = parse_json(folder.text("press.json"));
  EXPECT_NEAR(report["output_share"].get<double>(), 0.74, 0.03);
}

TEST(Press, TakesParametersAndPresetsAndRefusesBadOnes) {
  const Folder folder;
  const Called other =
      call({"--headless", "--press", folder.file("a"), "--preset", "by_74_percent", "--json"});
  EXPECT_EQ(other.code, 0) << other.err;
  EXPECT_NEAR(parse_json(other.out)["output_share"].get<double>(), 0.255, 0.015);
  const std::string file = folder.file("a/p.json");
  const auto with = [&](const std::string& text) {
    std::ofstream(file) << text;
    return call({"--headless", "--press", folder.file("b"), "--parameters", file});
  };
  EXPECT_EQ(with(R"({"circulation": {"left_atrial_mmhg": 5}})").code, 0);
  const Called bad = with(R"({"segments": {"apex": {"alpha": 2}}})");
  EXPECT_EQ(bad.code, 3);
  EXPECT_NE(bad.err.find("p.json"), std::string::npos);
  EXPECT_NE(bad.err.find("/segments/apex/alpha must be a number from 0 to 1"), std::string::npos);
  EXPECT_EQ(with("{").code, 3);
  EXPECT_EQ(call({"--headless", "--press", folder.file("b"), "--parameters", "none.json"}).code, 3);
  EXPECT_EQ(call({"--press", folder.file("b")}).code, 2);
  EXPECT_EQ(call({"--headless", "--press", folder.file("b"), "--press-depth-mm", "40"}).code, 2);
  EXPECT_EQ(call({"--headless", "--press", folder.file("b"), "--preset", "spleen"}).code, 2);
  EXPECT_EQ(call({"--headless"}).code, 2);  // neither a package nor the scene
  EXPECT_EQ(call({"--headless", "--press", file + "/c"}).code, 5);  // below a file
}

TEST(Plot, DrawsWhatItIsGivenAndRefusesNothing) {
  const std::string svg = plot::plots_svg({{.title = "a < b & c",
                                            .x_title = "x",
                                            .y_title = "y",
                                            .series = {{.name = "s", .x = {0, 1}, .y = {2, 4}}}}});
  EXPECT_NE(svg.find("a &lt; b &amp; c"), std::string::npos);
  EXPECT_NE(svg.find("<polyline"), std::string::npos);
  EXPECT_THROW((void)plot::plots_svg({}), Error);
  EXPECT_THROW((void)plot::plots_svg({{.title = "none",
                                       .x_title = "",
                                       .y_title = "",
                                       .series = {{.name = "", .x = {-1}, .y = {1}}},
                                       .log_x = true}}),
               Error);
  // A line of many samples keeps its highest and lowest.
  plot::PlotSeries many;
  for (int n = 0; n < 100000; ++n) {
    many.x.push_back(n);
    many.y.push_back(n == 54321 ? 7 : 0);
  }
  const std::string thinned =
      plot::plots_svg({{.title = "", .x_title = "", .y_title = "", .series = {many}}});
  EXPECT_LT(thinned.size(), 100000U);
  // The axis goes to 8 above the frame's height: the peak is drawn at 7/8 of it.
  EXPECT_NE(thinned.find(",64.0 "), std::string::npos);
}

}  // namespace
}  // namespace beatlas::app
