// A catheter's tip on an atlas: through the valve into the ventricle, to its far wall and back.

#include <cmath>
#include <fstream>
#include <functional>
#include <sstream>

#include <gtest/gtest.h>

#include "runtime/app/play.h"
#include "runtime/atlas/atlas.h"
#include "runtime/base/json_text.h"
#include "runtime/device/csv_table.h"
#include "tests/package/sample_package.h"
#include "tests/unit/runtime_app/played.h"

namespace beatlas::app::inside_tests {
namespace {

using beatlas::test::TemporaryFolder;
using test::Result;
using test::run;

const Vec3 kMiddle(128, 128, 96);  // of the sample's heart; its ventricle's radius is 18 to 22 mm

class Inside : public ::testing::Test {
 protected:
  void SetUp() override {
    pack::PackageContent content = beatlas::test::palpation_content();
    content.manifest.scene = "full";
    for (atlas::SurfaceMapPayload& map : content.maps) {
      for (auto& phase : map.thickness_mm) {
        for (std::size_t v = 0; v < phase.size(); ++v) {
          if (map.long_axis[v] >= 0.9F) phase[v] = 0;
        }
      }
    }
    pack::write_package(file("open.beatlas"), content);
    content.maps.clear();
    pack::write_package(file("plain.beatlas"), content);
    // Down the axis to the far wall, back up, and aside in the valve's tube.
    std::ofstream path(file("path.csv"));
    path << "t_s,x_mm,y_mm,z_mm\n";
    for (int n = 0; n <= 3000; ++n) {
      const double t = 0.001 * n;
      const double z = t < 1     ? 40 - 40 * t
                       : t < 1.5 ? -56 * (t - 1)
                       : t < 2.5 ? -28 + 66 * (t - 1.5)
                                 : 38;
      const double x = t < 2.5 ? 0 : 24 * (t - 2.5);
      path << t << ',' << kMiddle.x() + x << ',' << kMiddle.y() << ',' << kMiddle.z() + z << '\n';
    }
  }

  [[nodiscard]] std::string file(const std::string& name) const {
    return (folder_.path() / name).string();
  }

  struct Done {
    int code = 0;
    std::string err;
    std::vector<std::vector<double>> rows;  ///< t_s, fx_n, fz_n
  };
  [[nodiscard]] Done play_path(const std::string& package, bool valve) const {
    std::vector<std::string> words{
        "beatlas-play",     file(package), "--headless",     "--fast",         "--device",
        "replay",           "--recording", file("path.csv"), "--inside",       "lv_blood",
        "--tool-radius-mm", "1",           "--trace",        file("trace.csv")};
    if (valve) words.emplace_back("--valve");
    std::vector<const char*> argv;
    for (const std::string& word : words) argv.push_back(word.c_str());
    std::istringstream in;
    std::ostringstream out;
    std::ostringstream err;
    Done done;
    done.code = play(static_cast<int>(argv.size()), argv.data(), in, out, err);
    done.err = err.str();
    if (done.code == 0) {
      std::ifstream trace(file("trace.csv"));
      done.rows = device::read_csv(trace, "trace", {"t_s", "fx_n", "fz_n"}).rows;
    }
    return done;
  }

  TemporaryFolder folder_;
};

TEST_F(Inside, ATipComesThroughTheValveAndGoesOutAgain) {
  const Done done = play_path("open.beatlas", true);
  ASSERT_EQ(done.code, 0) << done.err;
  ASSERT_GE(done.rows.size(), 3000U);
  double far_wall_n = 0;
  double tube_n = 0;
  for (const std::vector<double>& row : done.rows) {
    const double t = row[0];
    const bool in_the_blood = t < 1.2 || (t > 1.8 && t < 2.5);
    if (in_the_blood) {
      ASSERT_EQ(std::hypot(row[1], row[2]), 0) << t;
    }
    if (t > 1.4 && t < 1.5) far_wall_n = std::max(far_wall_n, row[2]);
    if (t > 2.8) tube_n = std::min(tube_n, row[1]);
  }
  EXPECT_GT(far_wall_n, 0.5);
  EXPECT_LT(tube_n, -0.3);
}

TEST_F(Inside, WithTheValveClosedATipOutsideIsDrawnIn) {
  const Done done = play_path("open.beatlas", false);
  ASSERT_EQ(done.code, 0) << done.err;
  double held_n = 0;
  for (const std::vector<double>& row : done.rows) {
    if (row[0] > 0.2 && row[0] < 0.4) held_n = std::min(held_n, row[2]);
  }
  EXPECT_LT(held_n, -0.5);
}

TEST_F(Inside, AnAtlasThatDoesNotShowItsValveSaysSo) {
  const Done done = play_path("plain.beatlas", true);
  EXPECT_EQ(done.code, 3);
  EXPECT_NE(done.err.find("map"), std::string::npos) << done.err;
  EXPECT_NE(done.err.find("lv_blood"), std::string::npos) << done.err;
}

// In an effusion of 8 mm: pressed inward it meets the beating heart, outward the sac, and in
// between it is free.
TEST_F(Inside, AThinToolInThePericardiumMeetsTheHeartAndTheSac) {
  const auto felt = [&](double depth_mm) {
    const Result done =
        run({file("plain.beatlas"), "--headless", "--fast", "--seconds", "2", "--inside",
             "pericardium", "--effusion-mm", "8", "--tool-radius-mm", "1", "--hand", "still",
             "--depth-mm", std::to_string(depth_mm), "--trace", file("felt.csv"), "--json"});
    EXPECT_EQ(done.code, 0) << done.err;
    EXPECT_EQ(parse_json(done.out)["effusion_mm"], 8);
    std::ifstream trace(file("felt.csv"));
    double least = 1e9;
    double most = -1e9;
    // A finger that comes from the left feels the heart as a push to the left.
    const atlas::Manifest manifest = atlas::Atlas::open(file("plain.beatlas"), {}).manifest();
    const Vec3 left = manifest.workspace_from_lps.linear() * Vec3::UnitX();
    for (const auto& row : device::read_csv(trace, "trace", {"t_s", "fx_n", "fy_n", "fz_n"}).rows) {
      if (row[0] < 1) continue;  // behind the start ramp
      const double along = Vec3(row[1], row[2], row[3]).dot(left);
      least = std::min(least, along);
      most = std::max(most, along);
    }
    return std::pair(least, most);
  };
  const auto [free_least, free_most] = felt(-4);
  EXPECT_EQ(free_least, 0);
  EXPECT_EQ(free_most, 0);
  EXPECT_GT(felt(2).second, 0.2);
  EXPECT_LT(felt(-11).first, -0.2);
  const Result thick = run({file("plain.beatlas"), "--headless", "--inside", "pericardium"});
  EXPECT_EQ(thick.code, 2);
  EXPECT_NE(thick.err.find("--effusion-mm belong together"), std::string::npos) << thick.err;
}

}  // namespace
}  // namespace beatlas::app::inside_tests
