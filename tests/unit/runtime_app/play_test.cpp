#include "runtime/app/play.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "runtime/app/headless.h"
#include "runtime/base/json_text.h"
#include "runtime/device/csv_table.h"
#include "runtime/field/field_query.h"
#include "tests/json_file.h"
#include "tests/unit/runtime_app/played_ellipsoid.h"

namespace beatlas::app {
namespace {

using namespace test;

std::vector<std::vector<double>> numbers(const std::string& csv) {
  std::istringstream stream(csv);
  return device::read_csv(
             stream, "out",
             {"distance_mm", "nx", "ny", "nz", "velocity_mm_s", "fx_n", "fy_n", "fz_n"})
      .rows;
}

const Vec3 kInside = kCentre + Vec3(14, -12, 11);  // some mm deep
const std::string kHeader = "x_mm,y_mm,z_mm,t_s\n";

std::string row(const Vec3& x, double t) {
  std::ostringstream text;
  text.precision(17);
  text << x[0] << ',' << x[1] << ',' << x[2] << ',' << t << '\n';
  return text.str();
}

TEST(Probe, GivesTheClosedFormOfABeatingEllipsoid) {
  std::string input = kHeader;
  std::vector<std::pair<Vec3, double>> points;
  for (double t : {0.0, 0.1, 0.33, 0.79, -0.4, 8.05}) {
    for (double scale : {0.8, 0.95, 1.0, 1.1}) {
      const Vec3 direction(0.6, -0.48, 0.64);
      const Vec3 x = kCentre + scale / direction.cwiseQuotient(kAxes).norm() * direction;
      points.emplace_back(x, t);
      input += row(x, t);
    }
  }
  const Result result = run({"probe", package(), "--points", "-"}, input);
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_TRUE(result.out.starts_with(
      "x_mm,y_mm,z_mm,t_s,distance_mm,nx,ny,nz,velocity_mm_s,fx_n,fy_n,fz_n\n"));
  const auto rows = numbers(result.out);
  ASSERT_EQ(rows.size(), points.size());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const auto& [x, t] = points[r];
    const double d = distance_mm(x, t);
    EXPECT_NEAR(rows[r][0], d, 0.02);
    const Vec3 foot = testing::ellipsoid_nearest(kAxes + Vec3::Constant(growth(t)), x - kCentre);
    const Vec3 n = foot.cwiseQuotient((kAxes + Vec3::Constant(growth(t))).cwiseAbs2()).normalized();
    const Vec3 found(rows[r][1], rows[r][2], rows[r][3]);
    EXPECT_LT((found - n).norm(), 0.01);  // 0.6 degrees
    constexpr double h = 1e-4;
    const double velocity = -(distance_mm(x, t + h) - distance_mm(x, t - h)) / (2 * h);
    EXPECT_NEAR(rows[r][4], velocity, 0.15);  // of 11.8 mm/s; 10 phases
    const Vec3 force(rows[r][5], rows[r][6], rows[r][7]);
    EXPECT_LT((force - 0.180 * std::max(0.0, -rows[r][0]) * found).norm(), 1e-12);
  }
}

TEST(Probe, PatientAxesTurnPointsNormalsAndForces) {
  const Affine lps_from_workspace = workspace_from_lps().inverse();
  const Result workspace = run({"probe", package(), "--points", "-"}, kHeader + row(kInside, 0.1));
  const Result lps = run({"probe", package(), "--points", "-", "--frame", "lps"},
                         kHeader + row(lps_from_workspace * kInside, 0.1));
  ASSERT_EQ(lps.code, 0) << lps.err;
  const auto w = numbers(workspace.out).at(0);
  const auto p = numbers(lps.out).at(0);
  EXPECT_LT(w[0], -1);
  EXPECT_NEAR(p[0], w[0], 1e-5);
  EXPECT_NEAR(p[4], w[4], 1e-3);
  const Eigen::Matrix3d turn = lps_from_workspace.linear();
  EXPECT_LT((Vec3(p[1], p[2], p[3]) - turn * Vec3(w[1], w[2], w[3])).norm(), 1e-5);
  EXPECT_LT((Vec3(p[5], p[6], p[7]) - turn * Vec3(w[5], w[6], w[7])).norm(), 1e-5);
}

TEST(Probe, TellsHowWellTheSurfaceIsKnownIfThePackageDoes) {
  const std::string known = (folder() / "known.beatlas").string();
  const Vec3 aside = kCentre + Vec3(kAxes[0] - 2, 0, 0);
  const Vec3 above = kCentre + Vec3(0, 0, kAxes[2] - 2);
  const Affine lps_from_workspace = workspace_from_lps().inverse();
  for (const bool lps : {false, true}) {
    const Affine turn = lps ? lps_from_workspace : Affine::Identity();
    const Result result =
        run({"probe", known, "--points", "-", "--frame", lps ? "lps" : "workspace"},
            kHeader + row(turn * aside, 0.1) + row(turn * above, 0.1));
    ASSERT_EQ(result.code, 0) << result.err;
    std::istringstream stream(result.out);
    const auto rows = device::read_csv(stream, "out", {"band_mm", "band_n"}).rows;
    EXPECT_NEAR(rows.at(0)[0], 2, 0.02);
    EXPECT_NEAR(rows.at(1)[0], 5, 0.02);
    EXPECT_NEAR(rows.at(0)[1], 0.3 * rows.at(0)[0], 1e-9);  // 300 N/m
  }
  EXPECT_EQ(run({"probe", package(), "--points", "-"}, kHeader).out.find("band"),
            std::string::npos);
}

TEST(Probe, OutsideTheBandEverythingIsFiniteAndTheSignRight) {
  const Result result = run({"probe", package(), "--points", "-"},
                            kHeader + row(kCentre, 0.2) + row(kCentre + Vec3(0, 5, 0), 0.2) +
                                row(Vec3(1e6, 128, 96), 0.2) + row(Vec3(-300, 0, 0), 1e9));
  ASSERT_EQ(result.code, 0) << result.err;
  const auto rows = numbers(result.out);
  EXPECT_DOUBLE_EQ(rows.at(0)[0], -10);
  EXPECT_DOUBLE_EQ(rows.at(1)[0], -10);
  EXPECT_GT(rows.at(1)[2], 0.99);  // away from the centre, +y
  EXPECT_NEAR(rows.at(1)[6], 0.180 * 10, 0.01);
  EXPECT_DOUBLE_EQ(rows.at(2)[0], 6);
  EXPECT_GT(rows.at(2)[1], 0.99);
  EXPECT_EQ(rows.at(2)[5], 0);
  EXPECT_DOUBLE_EQ(rows.at(3)[0], 6);
  EXPECT_EQ(rows.at(3)[4], 0);
}

TEST(Probe, KeepsTheRowsOwnTextAndMoreColumns) {
  const std::string file = (folder() / "out.csv").string();
  const Result result = run({"probe", package(), "--points", "-", "-o", file},
                            "name,t_s,z_mm,y_mm,x_mm\nfirst,0.10,96.0,128,+128\n");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.out, "");
  std::ifstream stream(file);
  std::string header;
  std::string line;
  std::getline(stream, header);
  std::getline(stream, line);
  EXPECT_TRUE(header.starts_with("name,t_s,z_mm,y_mm,x_mm,distance_mm,"));
  EXPECT_TRUE(line.starts_with("first,0.10,96.0,128,+128,-10,"));
  const Result none = run({"probe", package(), "--points", "-"}, kHeader);
  EXPECT_EQ(none.code, 0);
  EXPECT_EQ(std::count(none.out.begin(), none.out.end(), '\n'), 1);
}

TEST(Probe, BadInputIsRefusedWithItsPlace) {
  const auto expect = [](const Result& result, int code, const std::string& words) {
    EXPECT_EQ(result.code, code) << result.err;
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
    EXPECT_EQ(result.out, "");
  };
  const std::string p = package();
  expect(run({"probe", p, "--points", "-"}, kHeader + "1,2,3,4\n1,2,x,4\n"), 3,
         "line 3, column z_mm");
  expect(run({"probe", p, "--points", "-"}, "x_mm,y_mm,z_mm\n1,2,3\n"), 3, "column t_s is missing");
  expect(run({"probe", p, "--points", "-"}, "x_mm,y_mm,z_mm,t_s,nx\n1,2,3,4,5\n"), 3, "column nx");
  expect(run({"probe", p, "--points", "-"}, "x_mm,y_mm,z_mm,t_s,band_mm\n1,2,3,4,5\n"), 3,
         "column band_mm");
  expect(run({"probe", p, "--points", "none.csv"}), 3, "none.csv");
  expect(run({"probe", p, "--points", folder().string()}), 3, "cannot be read; check its name");
  expect(run({"probe", "none.beatlas", "--points", "-"}, kHeader), 3, "none.beatlas");
  expect(run({"probe", p, "--points", "-", "--structure", "liver"}, kHeader), 2,
         "no structure liver; there are aorta, heart, la_blood");
  expect(run({"probe", p, "--points", "-", "--structure", "lv_blod"}, kHeader), 2,
         "did you mean lv_blood?");
  expect(run({"probe", p, "--points", "-", "--structure", "lv_blood"}, kHeader), 3, "lv_blood");
  expect(run({"probe", p, "--points", "-", "--frame", "ras"}, kHeader), 2, "frame");
  expect(run({"probe", p}), 2, "points");
  expect(run({"probe", p, "--points", "-", "-o", "/nowhere/out.csv"}, kHeader), 5,
         "/nowhere/out.csv");
}

TEST(Play, AStillHandFeelsTheClosedFormsForce) {
  const std::string trace = (folder() / "trace.csv").string();
  const Result result = run({package(), "--headless", "--fast", "--seconds", "3", "--hand", "still",
                             "--side", "left", "--depth-mm", "3", "--trace", trace, "--json"});
  ASSERT_EQ(result.code, 0) << result.err;
  const auto json = parse_json(result.out);
  EXPECT_EQ(json.at("ticks"), 3000);
  EXPECT_EQ(json.at("faults"), 0);
  EXPECT_EQ(json.at("contact_share"), 1);
  EXPECT_GT(json.at("compute_us").at("p50"), 0);
  // Left of the patient is -z of this workspace: pressed 3 mm in at end-diastole (t = 0), and the
  // surface comes 1.5 mm closer.
  EXPECT_NEAR(json.at("max_model_force_n"), 0.180 * 4.5, 0.004);
  EXPECT_NEAR(json.at("max_force_n"), 0.180 * 4.5, 0.004);
  std::ifstream stream(trace);
  const auto rows = device::read_csv(stream, "trace", {"t_s", "z_mm", "depth_mm", "fz_n"}).rows;
  ASSERT_EQ(rows.size(), 3000U);
  EXPECT_EQ(rows[0][3], 0);  // the ramp starts
  for (std::size_t r = 600; r < rows.size(); ++r) {
    ASSERT_NEAR(rows[r][1], 96 - 27, 0.01);
    ASSERT_NEAR(rows[r][2], 3 + growth(rows[r][0]), 0.02);
    ASSERT_NEAR(rows[r][3], -0.180 * rows[r][2], 1e-5);
  }
}

TEST(Play, ATipInACavityFeelsItsWallFromWithin) {
  const std::string cavity = (folder() / "cavity.beatlas").string();
  const std::string trace = (folder() / "inside.csv").string();
  const std::string ticks = (folder() / "inside.ticks").string();
  const Result result = run({cavity,     "--headless",       "--fast", "--seconds",
                             "2",        "--hand",           "still",  "--side",
                             "left",     "--depth-mm",       "3",      "--inside",
                             "lv_blood", "--tool-radius-mm", "1",      "--trace",
                             trace,      "--ticks",          ticks,    "--json"});
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(parse_json(result.out).at("inside"), "lv_blood");
  std::ifstream stream(trace);
  const auto rows = device::read_csv(stream, "trace", {"t_s", "z_mm", "depth_mm", "fz_n"}).rows;
  ASSERT_EQ(rows.size(), 2000U);
  // The tip's centre is held 3 mm behind the wall of end-diastole, to the left, which is -z; the
  // wall comes and goes by 1.5 mm, and pushes back to the right.
  for (std::size_t r = 600; r < rows.size(); ++r) {
    ASSERT_NEAR(rows[r][1], 96 - 33, 0.01);
    ASSERT_NEAR(rows[r][2], 1 + 3 - growth(rows[r][0]), 0.02);
    ASSERT_NEAR(rows[r][3], 0.180 * rows[r][2], 1e-5);
  }
  EXPECT_EQ(run({"replay-ticks", cavity, ticks}).code, 0);

  // In the middle of the blood there is nothing to feel.
  const Result free =
      run({cavity, "--headless", "--fast", "--seconds", "1", "--hand", "still", "--side", "left",
           "--depth-mm", "-20", "--inside", "lv_blood", "--json"});
  EXPECT_EQ(parse_json(free.out).at("max_model_force_n"), 0);

  const Result lacks = run({package(), "--headless", "--fast", "--inside", "rv_blood"});
  EXPECT_EQ(lacks.code, 3);
  EXPECT_NE(lacks.err.find("rv_blood"), std::string::npos) << lacks.err;
  EXPECT_EQ(run({cavity, "--headless", "--inside", "lv_blood", "--model", "patch"}).code, 2);
  EXPECT_EQ(run({cavity, "--headless", "--inside", "heart"}).code, 2);
}

TEST(Play, AReplayedTraceGivesTheSameForces) {
  const std::string first = (folder() / "first.csv").string();
  const std::string second = (folder() / "second.csv").string();
  ASSERT_EQ(run({package(), "--headless", "--fast", "--seconds", "1.5", "--trace", first}).code, 0);
  const Result replay = run({package(), "--headless", "--fast", "--device", "replay", "--recording",
                             first, "--trace", second});
  ASSERT_EQ(replay.code, 0) << replay.err;
  const auto read = [](const std::string& file) {
    std::ifstream stream(file);
    return device::read_csv(stream, file, {"fx_n", "fy_n", "fz_n"}).rows;
  };
  const auto a = read(first);
  const auto b = read(second);
  ASSERT_EQ(a.size(), 1500U);
  ASSERT_EQ(b.size(), a.size());
  double largest = 0;
  for (std::size_t r = 0; r < a.size(); ++r) {
    for (std::size_t c = 0; c < 3; ++c) largest = std::max(largest, std::abs(a[r][c] - b[r][c]));
  }
  EXPECT_LT(largest, 1e-6);
}

TEST(Play, RunsAtOneKilohertzInRealTime) {
  const Result result = run({package(), "--headless", "--seconds", "0.3", "--json"});
  const auto json = parse_json(result.out);
  // A busy machine may leave ticks out, and a gap may be a fault; it never adds any.
  ASSERT_EQ(result.code, json.at("faults") > 0 ? 5 : 0) << result.err;
  EXPECT_LE(json.at("ticks"), 300);
  EXPECT_GE(json.at("ticks"), 3);
  EXPECT_EQ(json.at("pace"), "real_time");
}

TEST(Play, UsageErrorsAreExitCodeTwo) {
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{},
                                             {package()},
                                             {package(), "--headless", "--device", "replay"},
                                             {package(), "--headless", "--recording", "x.csv"},
                                             {package(), "--what"},
                                             {package(), "--headless", "--seconds", "-1"},
                                             {package(), "--headless", "--scene", "x"}}) {
    const Result result = run(words);
    EXPECT_EQ(result.code, 2) << result.err;
    EXPECT_FALSE(result.err.empty());
  }
  EXPECT_NE(run({package()}).err.find("viewer"), std::string::npos);
  const Result help = run({"--help"});
  EXPECT_EQ(help.code, 0);
  EXPECT_NE(help.out.find("--headless"), std::string::npos);
  EXPECT_NE(run({"probe", "--help"}).out.find("--points"), std::string::npos);
}

TEST(Play, TheSchemaNamesEveryKeyOfTheReport) {
  const Result result = run({package(), "--headless", "--fast", "--seconds", "0.1", "--json"});
  ASSERT_EQ(result.code, 0) << result.err;
  const auto report = parse_json(result.out);
  const auto schema = beatlas::test::json_file(BEATLAS_SOURCE_DIR "/schemas/play.schema.json");
  for (const auto& item : report.items()) EXPECT_TRUE(schema["properties"].contains(item.key()));
  ASSERT_GT(schema["else"]["required"].size(), 10U);
  for (const auto& key : schema["else"]["required"]) EXPECT_TRUE(report.contains(key)) << key;
}

}  // namespace
}  // namespace beatlas::app
