/// The press on an atlas's own left ventricle: it goes where it is told, as deep as it is told, and
/// what it feels is the muscle that lies there.

#include "runtime/app/atlas_press.h"

#include <fstream>
#include <iterator>
#include <numeric>
#include <sstream>

#include <gtest/gtest.h>

#include "runtime/app/play.h"
#include "runtime/app/press_session.h"
#include "runtime/app/region_maps.h"
#include "runtime/base/error.h"
#include "runtime/base/json_text.h"
#include "runtime/device/csv_table.h"
#include "runtime/field/field_query.h"
#include "tests/package/sample_package.h"
#include "tests/unit/runtime_app/played.h"

namespace beatlas::app {
namespace {

using beatlas::test::TemporaryFolder;

/// The sample that can be palpated, its wall thinner than it is.
pack::PackageContent content_of(double thinner = 0) {
  pack::PackageContent content = beatlas::test::palpation_content();
  for (auto& phase : content.maps.at(0).thickness_mm) {
    for (float& mm : phase) mm = std::max(0.5F, mm - float(thinner));
  }
  return content;
}

class AtlasPresses : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<TemporaryFolder>();
    pack::write_package(file("heart.beatlas"), content_of());
    pack::PackageContent plain = content_of();
    plain.maps.clear();
    plain.manifest.scene = "full";
    pack::write_package(file("plain.beatlas"), plain);
    pack::write_package(file("buried.beatlas"), content_of(6.5));
  }
  static void TearDownTestSuite() { folder_.reset(); }
  static std::string file(const std::string& name) { return (folder_->path() / name).string(); }

  static atlas::Atlas open(const std::string& name) {
    const auto manifest = atlas::Atlas::open(file(name), {}).manifest();
    return atlas::Atlas::open(file(name), needs_of_press(manifest));
  }
  static AtlasPress press(const std::string& name, const std::string& preset, int segment,
                          double depth_mm) {
    const atlas::Atlas package = open(name);
    const palpation::PalpationParameters parameters = palpation::palpation_preset(preset);
    std::optional<AtlasVentricle> ventricle;
    if (const auto wall = palpation::lv_wall_of(package)) {
      ventricle =
          AtlasVentricle{wall, palpation::tissue_of_wall(*wall, parameters.segments, {}, {})};
    }
    return press_on_atlas(
        package, parameters,
        {.depth_mm = depth_mm, .natural_s = 1, .held_s = 2, .after_s = 1, .segment = segment},
        ventricle);
  }
  /// What a session says, or its error.
  static std::string session(const std::string& package, const std::string& parameters,
                             const std::string& segment = "") {
    PressArguments arguments;
    arguments.folder = file("out");
    arguments.package = package.empty() ? "" : file(package);
    arguments.segment = segment;
    arguments.json = true;
    arguments.script.held_s = 2;
    if (!parameters.empty()) {
      std::ofstream(file("p.json")) << parameters;
      arguments.parameters = file("p.json");
    }
    std::ostringstream out;
    try {
      run_press_session(arguments, out);
    } catch (const Error& error) {
      return error.what();
    }
    return out.str();
  }

  static inline std::unique_ptr<TemporaryFolder> folder_;
};

TEST_F(AtlasPresses, TouchTheSegmentTheyAreToldOnTheHeartsSurface) {
  const atlas::Atlas package = open("heart.beatlas");
  const field::FieldQuery heart(package.field(Structure::Heart), package.manifest().rr_interval_s);
  EXPECT_EQ(package.field(Structure::LvBlood), nullptr);
  for (const int segment : {1, 7, 10, 12, 16}) {
    const AtlasPress found = press("heart.beatlas", "healthy", segment, 2);
    ASSERT_TRUE(found.wall.has_value());
    EXPECT_EQ(found.wall->place.segment, segment);
    EXPECT_NEAR(heart.sample(found.place_mm, 0).distance_mm, 0, 0.01);
    EXPECT_NEAR(found.outward.norm(), 1, 1e-9);
    EXPECT_GT(found.outward.dot((found.place_mm - Vec3(128, 128, 96)).normalized()), 0.9);
    EXPECT_NEAR(found.wall->place.away_mm, 14.4, 3);  // between the two balls, with their bumps
  }
}

TEST_F(AtlasPresses, AreAsDeepBelowTheMovingSurfaceAsTheFingerAndTheBeatMakeThem) {
  const AtlasPress found = press("heart.beatlas", "healthy", 7, 3);
  const atlas::Atlas package = open("heart.beatlas");
  const double rr_s = package.manifest().rr_interval_s;
  const field::FieldQuery heart(package.field(Structure::Heart), rr_s);
  const double speed = palpation::PalpationParameters{}.circulation.heart_rate_per_min / 60 * rr_s;
  int in_contact = 0;
  double least_mm = 100;
  for (std::size_t n = 0; n < found.rows.size(); n += 13) {
    const AtlasPressRow& row = found.rows[n];
    const Vec3 finger = found.place_mm - row.displacement_mm * found.outward;
    EXPECT_NEAR(row.depth_mm, -heart.sample(finger, speed * row.time_s).distance_mm, 1e-6);
    EXPECT_LE(row.displacement_mm, 3 + 1e-9);
    EXPECT_GE(row.force_n, 0);
    EXPECT_TRUE(row.depth_mm > -0.5 || row.force_n == 0) << row.time_s;
    in_contact += row.force_n > 0 ? 1 : 0;
    least_mm = std::min(least_mm, row.depth_mm);
  }
  EXPECT_GT(in_contact, 20);
  EXPECT_NEAR(found.deepest_mm, 3, 0.05);  // at end-diastole
  EXPECT_LT(least_mm, -1.5);               // the wall draws back by 5.4 in systole
  EXPECT_EQ(found.rows.front().displacement_mm, 0);
  EXPECT_EQ(found.rows.back().displacement_mm, 0);
}

TEST_F(AtlasPresses, FeelHealthyMuscleAsTableOneHasIt) {
  const AtlasPress found = press("heart.beatlas", "healthy", 7, 4);
  ASSERT_EQ(found.tissues.size(), 3U);
  // 2 mm below a wall that it goes with, relaxed: the vertical spring, what Emin adds, and what the
  // pressure of filling does.
  const palpation::PalpationParameters parameters;
  palpation::Circulation circulation(parameters.circulation);
  circulation.settle();
  const double k_n_per_m = parameters.at(found.wall->place.long_axis, 7).k_v_n_per_m +
                           palpation::contractile_n_per_m(parameters, 1, circulation) +
                           palpation::pressure_n_per_m(circulation);
  EXPECT_NEAR(found.tissues[0].with_wall.diastole_n, 2e-3 * k_n_per_m, 0.1 * 2e-3 * k_n_per_m);
  EXPECT_GT(found.tissues[0].with_wall.systole_n, 1.1 * found.tissues[0].with_wall.diastole_n);
  EXPECT_EQ(found.tissues[0].with_wall.diastole_jnd, 0);
  // Nobody is ill: the place as it is feels healthy.
  EXPECT_EQ(found.tissues[2].with_wall.force_n, found.tissues[0].with_wall.force_n);
  EXPECT_EQ(found.tissues[2].in_space.systole_jnd, 0);
}

TEST_F(AtlasPresses, TellAnInfarctFromHealthyMuscleByForce) {
  const AtlasPress ill = press("heart.beatlas", "anterior_infarct", 7, 8);
  EXPECT_EQ(ill.wall->tissue, palpation::infarct_tissue());
  const TissueForce& infarct = ill.tissues[1];
  EXPECT_GT(infarct.with_wall.diastole_jnd, 2);
  EXPECT_GT(infarct.with_wall.systole_jnd, infarct.with_wall.diastole_jnd);
  EXPECT_LT(infarct.with_wall.systole_n, ill.tissues[0].with_wall.systole_n);
  EXPECT_EQ(ill.tissues[2].with_wall.diastole_jnd, infarct.with_wall.diastole_jnd);
  EXPECT_LT(ill.largest_force_n, press("heart.beatlas", "healthy", 7, 8).largest_force_n);
  // Beside it the muscle itself is healthy.
  const AtlasPress beside = press("heart.beatlas", "anterior_infarct", 10, 8);
  EXPECT_EQ(beside.wall->tissue, palpation::Tissue{});
  EXPECT_EQ(beside.tissues[2].with_wall.diastole_jnd, 0);
}

TEST_F(AtlasPresses, ThatOtherHeartLiesUnderAreRefusedByTheSegmentsName) {
  try {
    (void)press("buried.beatlas", "healthy", 8, 4);
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
    EXPECT_NE(std::string(error.what()).find("mid_anteroseptal from outside"), std::string::npos)
        << error.what();
  }
}

TEST_F(AtlasPresses, NotToldWherePressWhereAFingerCanReach) {
  const auto segment = [](const std::string& package) {
    const std::string said = session(package, "");
    EXPECT_EQ(said.front(), '{') << said;
    return parse_json(said)["atlas"]["wall"]["segment"].get<std::string>();
  };
  EXPECT_EQ(segment("heart.beatlas"), "mid_anterior");
  EXPECT_NE(session("buried.beatlas", "").find("can reach no segment"), std::string::npos);
}

TEST_F(AtlasPresses, WithoutAMapPressTheFreeWallAsBefore) {
  const AtlasPress found = press("plain.beatlas", "healthy", 7, 4);
  EXPECT_FALSE(found.wall.has_value());
  EXPECT_TRUE(found.tissues.empty());
  EXPECT_NEAR(found.deepest_mm, 4, 0.1);
  EXPECT_GT(found.largest_force_n, 0.1);
  EXPECT_FALSE(atlas_press_json(found).contains("wall"));
}

TEST_F(AtlasPresses, TakeRegionsOfThinWallAndPaintedOnes) {
  // The wall is 8.2 mm and a millimetre more or less: thin is what lies away from the septum.
  const auto thin = parse_json(session(
      "heart.beatlas", R"({"regions": [{"thinner_than_mm": 7.6, "scar": 0.7, "alpha": 0.1}]})",
      "mid_inferolateral"))["atlas"];
  EXPECT_EQ(thin["wall"]["segment"], "mid_inferolateral");
  EXPECT_EQ(thin["wall"]["scar"], 0.7);
  EXPECT_LT(thin["wall"]["thickness_mm"], 7.6);
  EXPECT_NEAR(thin["wall"]["thickness_ratio"].get<double>(),
              thin["wall"]["thickness_mm"].get<double>() / 8.5, 0.06);
  EXPECT_GT(thin["tissues"][2]["with_wall"]["systole_jnd"], 1);
  const auto thick = parse_json(session(
      "heart.beatlas", R"({"regions": [{"thinner_than_mm": 7.6, "scar": 0.7, "alpha": 0.1}]})",
      "mid_inferoseptal"))["atlas"];
  EXPECT_EQ(thick["wall"]["alpha"], 1);

  std::ofstream(file("scar.csv")) << "segment,label\n7,2\n8,1\n";
  const std::string painted =
      R"({"regions": [{"painted": "scar.csv", "label": 2, "alpha": 0.3, "thickness_ratio": 0.8}]})";
  EXPECT_EQ(parse_json(session("heart.beatlas", painted, "mid_anterior"))["atlas"]["wall"]["alpha"],
            0.3);
  EXPECT_EQ(
      parse_json(session("heart.beatlas", painted, "mid_anteroseptal"))["atlas"]["wall"]["alpha"],
      1);
  std::ofstream(file("scar.csv")) << "vertex,label\n0,2\n99999,2\n";
  EXPECT_NE(session("heart.beatlas", painted).find("'99999,2' must hold a vertex from 0 to"),
            std::string::npos);
  std::ofstream(file("scar.csv")) << "segment,label\n18,2\n";
  EXPECT_NE(session("heart.beatlas", painted).find("must hold a segment from 1 to 17"),
            std::string::npos);
  std::ofstream(file("scar.csv")) << "segment,label\n7,2.5\n";
  EXPECT_NE(session("heart.beatlas", painted).find("must hold a label from 0 to 255"),
            std::string::npos);
  std::filesystem::remove(file("scar.csv"));
  EXPECT_NE(session("heart.beatlas", painted).find("scar.csv cannot be read"), std::string::npos);
  EXPECT_NE(session("", painted).find("name a package"), std::string::npos);
  const std::string outside = R"({"regions": [{"painted": "/etc/passwd", "label": 2}]})";
  EXPECT_NE(session("heart.beatlas", outside).find("outside the folder"), std::string::npos);
  EXPECT_NE(session("plain.beatlas", painted).find("no map of the LV's wall"), std::string::npos);
}

TEST_F(AtlasPresses, TakeAMeasuredStiffness) {
  const auto felt = [](const std::string& parameters) {
    const std::string said = session("heart.beatlas", parameters, "mid_anterior");
    EXPECT_EQ(said.front(), '{') << said;
    return parse_json(said)["atlas"];
  };
  const std::string measured =
      R"({"regions": [{"measured": "e.csv", "healthy_kpa": 10, "reach_mm": 50}]})";
  // One point in the middle of the ventricle's wall tells of all within 50 mm.
  const atlas::Atlas atlas = atlas::Atlas::open(
      file("heart.beatlas"),
      {.fields = {}, .surfaces = {Structure::LvBlood}, .maps = {Structure::LvBlood}});
  const auto wall = palpation::lv_wall_of(atlas);
  const std::uint32_t vertex = wall->middle_of(7);
  const Vec3 lps = atlas.manifest().workspace_from_lps.inverse() * wall->mm(vertex);
  const auto write = [&](const Vec3& at, const char* kpa) {
    std::ofstream(file("e.csv")) << "x_mm,y_mm,z_mm,kpa\n"
                                 << at.x() << ',' << at.y() << ',' << at.z() << ',' << kpa << '\n';
  };
  write(lps, "30");
  const auto hard = felt(measured);
  write(lps, "10");
  const auto healthy = felt(measured);
  EXPECT_EQ(hard["wall"]["stiffness_ratio"], 3);
  EXPECT_EQ(healthy["wall"]["stiffness_ratio"], 1);
  EXPECT_GT(hard["largest_force_n"].get<double>(), 1.3 * healthy["largest_force_n"].get<double>());

  std::ofstream(file("e.csv")) << "vertex,kpa\n" << vertex << ",25\n";
  EXPECT_EQ(felt(measured)["wall"]["stiffness_ratio"], 2.5);
  const auto refused = [&](const std::string& words) {
    const std::string said = session("heart.beatlas", measured, "mid_anterior");
    EXPECT_NE(said.find(words), std::string::npos) << said;
  };
  write(lps + Vec3(0, 0, 400), "10");
  refused("mm of the patient's frame (LPS)");
  write(lps, "10000");
  refused("is it in Pa or MPa?");
  write(lps, "-3");
  refused("is it in Pa or MPa?");
  std::ofstream(file("e.csv")) << "x_mm,y_mm,kpa\n1,2,3\n";
  refused("z_mm");
  std::ofstream(file("e.csv")) << "x_mm,y_mm,z_mm,kpa\n";
  refused("must have 1 to");
  std::filesystem::remove(file("e.csv"));
  refused("e.csv cannot be read");
}

// What beatlas-play's words do with a device, against the scripted press on the same segment.
// Several fingers on the muscle have one circulation: what one displaces changes what another
// feels, and where no clock paces them every run is the same.
TEST_F(AtlasPresses, OfSeveralFingersHaveOneCirculation) {
  const auto bytes_of = [](const std::string& name) {
    std::ifstream stream(name, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(stream), {});
  };
  struct Run {
    nlohmann::json report;
    std::string first_trace;
  };
  const auto run_with = [&](double second_depth_mm) -> Run {
    std::ofstream(file("two.json")) << nlohmann::json{
        {"version", 1},
        {"fingers",
         {{{"side", "left"}, {"hand", "still"}, {"depth_mm", 5}},
          {{"side", "anterior"}, {"hand", "still"}, {"depth_mm", second_depth_mm}}}}};
    const test::Result result = test::run(
        {file("heart.beatlas"), "--headless", "--fast", "--seconds", "8", "--tool-radius-mm", "5",
         "--model", "patch", "--fingers", file("two.json"), "--json", "--trace", file("two.csv")});
    EXPECT_EQ(result.code, 0) << result.err;
    return {parse_json(result.out), bytes_of(file("two_1.csv"))};
  };
  // One that ends before the others is lifted at the same tick of theirs, every time.
  {
    std::ofstream path(file("short.csv"));
    path << "t_s,x_mm,y_mm,z_mm\n0,128,128,146\n0.4,128,128,130\n1.3,128,128,130\n";
    std::ofstream(file("three.json"))
        << nlohmann::json{{"version", 1},
                          {"fingers",
                           {{{"device", "replay"}, {"recording", "short.csv"}},
                            {{"side", "left"}, {"hand", "palpation"}, {"depth_mm", 4}},
                            {{"side", "anterior"}, {"hand", "still"}, {"depth_mm", 4}}}}};
  }
  std::string first;
  for (int again = 0; again < 6; ++again) {
    const test::Result result =
        test::run({file("heart.beatlas"), "--headless", "--fast", "--seconds", "3", "--model",
                   "patch", "--fingers", file("three.json"), "--trace", file("three.csv")});
    ASSERT_EQ(result.code, 0) << result.err;
    const std::string traces = bytes_of(file("three_1.csv")) + bytes_of(file("three_2.csv")) +
                               bytes_of(file("three_3.csv"));
    if (again == 0) first = traces;
    EXPECT_EQ(traces, first) << again;
  }
  const Run alone = run_with(-30);
  const Run both = run_with(8);
  const Run again = run_with(8);
  EXPECT_EQ(both.first_trace, again.first_trace);
  EXPECT_NE(both.first_trace, alone.first_trace);
  const auto output = [](const Run& run) {
    return run.report["circulation"]["output_l_per_min"].get<double>();
  };
  const double natural = alone.report["circulation"]["natural_output_l_per_min"];
  EXPECT_LT(output(alone), 0.98 * natural);
  EXPECT_LT(output(both), output(alone) - 0.03 * natural);
  EXPECT_EQ(both.report["fingers"].size(), 2U);
}

TEST_F(AtlasPresses, AndADeviceFeelTheSameDiseaseAtTheSamePlace) {
  constexpr double kDepthMm = 5;
  constexpr int kBeats = 8;
  const atlas::Atlas package = open("heart.beatlas");
  const double rr_s = package.manifest().rr_interval_s;
  const auto mean = [](const std::vector<double>& all) {
    return std::accumulate(all.begin(), all.end(), 0.0) / static_cast<double>(all.size());
  };
  struct Felt {
    double press_n;
    double device_n;
  };
  const auto feel = [&](const std::string& preset, int segment) -> Felt {
    const ToldMuscle told = told_muscle("", preset);
    const auto ventricle = ventricle_of(package, told, "heart.beatlas");
    palpation::PalpationParameters parameters = told.parameters;
    parameters.infarct = ventricle->tissue.infarct;
    scale_to_atlas(parameters, package.manifest(), "heart.beatlas");
    const AtlasPress found =
        press_on_atlas(package, parameters, {.depth_mm = kDepthMm, .segment = segment}, ventricle);
    const Vec3 at = found.place_mm - kDepthMm * found.outward;
    {
      std::ofstream path(file("path.csv"));
      path << "t_s,x_mm,y_mm,z_mm\n";
      for (const double t : {0.0, (kBeats + 0.5) * rr_s}) {
        path << t << "," << at.x() << "," << at.y() << "," << at.z() << "\n";
      }
    }
    std::vector<std::string> words{
        "beatlas-play", file("heart.beatlas"), "--headless", "--fast",         "--device", "replay",
        "--recording",  file("path.csv"),      "--model",    "patch",          "--preset", preset,
        "--trace",      file("trace.csv"),     "--ticks",    file("ticks.txt")};
    std::vector<const char*> argv;
    for (const std::string& word : words) argv.push_back(word.c_str());
    std::istringstream in;
    std::ostringstream out;
    std::ostringstream err;
    EXPECT_EQ(play(static_cast<int>(argv.size()), argv.data(), in, out, err), 0) << err.str();
    std::ifstream trace(file("trace.csv"));
    std::vector<double> forces;
    for (const auto& row : device::read_csv(trace, "trace", {"t_s", "fx_n", "fy_n", "fz_n"}).rows) {
      if (row[0] >= (kBeats - 1) * rr_s && row[0] < kBeats * rr_s) {
        forces.push_back(Vec3(row[1], row[2], row[3]).norm());
      }
    }
    const std::string package_file = file("heart.beatlas");
    const std::string ticks_file = file("ticks.txt");
    const char* again[] = {"beatlas-play", "replay-ticks", package_file.c_str(),
                           ticks_file.c_str()};
    EXPECT_EQ(play(4, again, in, out, err), 0) << err.str();
    EXPECT_NE(out.str().find("all the same to the bit"), std::string::npos) << out.str();
    return {mean(found.tissues[2].in_space.force_n), mean(forces)};
  };
  const Felt healthy = feel("healthy", 7);
  const Felt ill = feel("anterior_infarct", 7);
  const Felt beside = feel("anterior_infarct", 11);
  const Felt low = feel("low_pressure", 7);
  for (const Felt& one : {healthy, ill, beside, low}) {
    EXPECT_NEAR(one.device_n, one.press_n, 0.02 * one.press_n);
  }
  EXPECT_GT(palpation::force_jnds(ill.device_n, healthy.device_n), 2);
  EXPECT_GT(palpation::force_jnds(ill.device_n, beside.device_n), 2);
  // Paper B's own experiment: the ventricle is the same, and less full.
  EXPECT_GT(palpation::force_jnds(low.device_n, healthy.device_n), 2);
  EXPECT_LT(low.device_n, healthy.device_n);
}

}  // namespace
}  // namespace beatlas::app
