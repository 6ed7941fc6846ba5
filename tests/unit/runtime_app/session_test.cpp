// beatlas-play with devices, models and recordings, on the golden package.

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "runtime/app/headless.h"
#include "runtime/app/ticks.h"
#include "runtime/app/touch.h"
#include "runtime/atlas/atlas.h"
#include "runtime/base/error.h"
#include "runtime/base/json_text.h"
#include "runtime/device/csv_table.h"
#include "runtime/field/surface_point.h"
#include "tests/unit/runtime_app/played.h"

namespace beatlas::app {
using test::Result;
using test::run;
namespace {

const std::string kGolden = BEATLAS_GOLDEN_PACKAGE;

// A file of this process's own, removed at the end.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& name)
      : path_(std::filesystem::temp_directory_path() /
              ("beatlas_session_" + std::to_string(::getpid()) + "_" + name)) {}
  ~TemporaryFile() { std::filesystem::remove(path_); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  [[nodiscard]] std::string path() const { return path_.string(); }
  [[nodiscard]] std::string text() const {
    std::ifstream stream(path_);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

 private:
  std::filesystem::path path_;
};

nlohmann::json report_of(std::vector<std::string> words) {
  words.insert(words.begin(), {kGolden, "--headless", "--fast", "--json", "--depth-mm", "1",
                               "--amplitude-mm", "1.5"});
  const Result result = run(words);
  EXPECT_EQ(result.code, 0) << result.err;
  return result.code == 0 ? parse_json(result.out) : nlohmann::json();
}

TEST(Session, EveryModelTouchesThePackage) {
  const nlohmann::json proxy = report_of({});
  EXPECT_EQ(proxy.at("model"), "proxy");
  const nlohmann::json two_step = report_of({"--model", "two_step"});
  const nlohmann::json published = report_of({"--published"});
  EXPECT_EQ(published.at("model"), "published");
  // On a thick smooth body a point proxy and the two-step model feel the same, as deep as the field
  // knows distances; deeper the two-step model's depth stays that of the band.
  EXPECT_NEAR(proxy.at("max_model_force_n"), two_step.at("max_model_force_n"), 0.02);
  EXPECT_NEAR(published.at("max_model_force_n"), two_step.at("max_model_force_n"), 0.05);
  const nlohmann::json sphere = report_of({"--tool-radius-mm", "2"});
  EXPECT_EQ(sphere.at("tool_radius_mm"), 2);
  EXPECT_GT(sphere.at("max_model_force_n"), proxy.at("max_model_force_n").get<double>() + 0.2);
  const nlohmann::json fingertip =
      report_of({"--model", "fingertip", "--tool-points", "300", "--seconds", "2"});
  EXPECT_EQ(fingertip.at("tool_radius_mm"), 8);
  EXPECT_GT(fingertip.at("max_model_force_n"), 0.1);
  const nlohmann::json quick = report_of({"--heart-rate", "120"});
  EXPECT_EQ(quick.at("heart_rate_per_min"), 120);
  EXPECT_EQ(run({kGolden, "--headless", "--tool-radius-mm", "40"}).code, 3);
  EXPECT_EQ(run({kGolden, "--headless", "--heart-rate", "5"}).code, 2);
  EXPECT_EQ(run({kGolden, "--headless", "--friction-dynamic", "0.5"}).code, 3);
}

TEST(Session, RecordedTicksComeOutTheSameAndAnothersAreRefused) {
  const TemporaryFile ticks("ticks.txt");
  for (const char* const model : {"proxy", "two_step", "fingertip"}) {
    (void)report_of({"--ticks", ticks.path(), "--seconds", "1", "--model", model, "--held",
                     "--tool-points", "100", "--friction-static", "0.4"});
    const Result replay = run({"replay-ticks", kGolden, ticks.path()});
    EXPECT_EQ(replay.code, 0) << replay.err;
    EXPECT_EQ(replay.out, "1000 ticks replayed, all the same to the bit; 0 faults\n");
  }
  // Another stiffness, another package.
  (void)report_of({"--ticks", ticks.path(), "--seconds", "1"});
  std::string text = ticks.text();
  const std::size_t stiffness = text.find("\"stiffness_n_per_m\":");
  ASSERT_NE(stiffness, std::string::npos);
  std::string softer = text;
  char& digit = softer[stiffness + 20];
  digit = digit == '1' ? '2' : '1';
  std::ofstream(ticks.path()) << softer;
  const Result differs = run({"replay-ticks", kGolden, ticks.path()});
  EXPECT_EQ(differs.code, 3);
  EXPECT_NE(differs.err.find("come out otherwise, first line"), std::string::npos) << differs.err;
  text.replace(text.find("field_sha256\":\"") + 15, 4, "0000");
  std::ofstream(ticks.path()) << text;
  const Result other = run({"replay-ticks", kGolden, ticks.path()});
  EXPECT_EQ(other.code, 3);
  EXPECT_NE(other.err.find("another package"), std::string::npos) << other.err;
  EXPECT_EQ(run({"replay-ticks", kGolden, "none.txt"}).code, 3);
  EXPECT_EQ(run({"replay-ticks", kGolden, kGolden}).code, 3);
  EXPECT_EQ(run({"replay-ticks", kGolden}).code, 2);
}

// A vendor's device that sits in its middle: nothing is touched there, 20 mm outside.
TEST(Session, AVendorsDevicePlaysForAsLongAsItIsTold) {
  const TemporaryFile trace("trace.csv");
  const Result result = run({kGolden, "--headless", "--device", "dhd", "--device-library", FAKE_DHD,
                             "--seconds", "0.05", "--trace", trace.path(), "--json"});
  const nlohmann::json json = parse_json(result.out);
  // Where others hold the machine, a gap may be a fault.
  ASSERT_EQ(result.code, json.at("faults") > 0 ? 5 : 0) << result.err;
  EXPECT_EQ(json.at("device"), "dhd");
  EXPECT_GE(json.at("ticks"), 2);
  EXPECT_LE(json.at("ticks"), 52);
  // The library's (0.01, 0.02, 0.03) m is right 20, up 30, towards the user 10 mm: in the patient's
  // axes 20 left, -10 posterior, 30 superior, from 20 mm outside of the left side's surface.
  const atlas::Atlas atlas =
      atlas::Atlas::open(kGolden, {.fields = {Structure::Heart}, .surfaces = {}});
  const atlas::Manifest& manifest = atlas.manifest();
  const field::FieldQuery field(atlas.field(Structure::Heart), manifest.rr_interval_s);
  const Vec3 left = manifest.workspace_from_lps.linear() * Vec3::UnitX();
  const double end_diastole_s = manifest.rr_interval_s * manifest.end_diastole / field.phases();
  const Vec3 expected = field::surface_point_mm(field, left, end_diastole_s) + 20 * left +
                        manifest.workspace_from_lps.linear() * Vec3(20, -10, 30);
  std::istringstream stream(trace.text());
  const auto rows = device::read_csv(stream, "trace", {"x_mm", "y_mm", "z_mm", "fx_n"}).rows;
  ASSERT_FALSE(rows.empty());
  EXPECT_LT((Vec3(rows[0][0], rows[0][1], rows[0][2]) - expected).norm(), 1e-6);
}

TEST(Session, ALostDeviceStillLeavesItsTraceAndTheTicksOfTheFault) {
  ::setenv("FAKE_DHD", "lost", 1);
  const TemporaryFile trace("lost.csv");
  const TemporaryFile ticks("lost.txt");
  const Result result = run({kGolden, "--headless", "--device", "dhd", "--device-library", FAKE_DHD,
                             "--trace", trace.path(), "--ticks", ticks.path(), "--json"});
  ::unsetenv("FAKE_DHD");
  EXPECT_EQ(result.code, 5);
  EXPECT_NE(result.err.find("was lost"), std::string::npos) << result.err;
  EXPECT_GE(parse_json(result.out).at("faults"), 1);
  const std::string rows = trace.text();
  EXPECT_GE(std::count(rows.begin(), rows.end(), '\n'), 20);
  const Result replay = run({"replay-ticks", kGolden, ticks.path()});
  EXPECT_EQ(replay.code, 0) << replay.err;
  EXPECT_EQ(replay.out.find(" 0 faults"), std::string::npos) << replay.out;
}

// The device does not know where it is, three times.
TEST(Session, FaultsEndInAnErrorAfterTheReport) {
  ::setenv("FAKE_DHD", "blind", 1);
  const TemporaryFile ticks("stalled.txt");
  const std::vector<std::string> words{
      kGolden,  "--headless", "--device", "dhd",   "--device-library",
      FAKE_DHD, "--seconds",  "0.2",      "--json"};
  const Result result = run(words);
  std::vector<std::string> with_ticks = words;
  with_ticks.insert(with_ticks.end(), {"--ticks", ticks.path()});
  const Result kept = run(with_ticks);
  ::unsetenv("FAKE_DHD");
  EXPECT_EQ(result.code, 5);
  const nlohmann::json report = parse_json(result.out);
  const auto faults = report.at("faults").get<std::int64_t>();
  EXPECT_GE(faults, 1);
  EXPECT_NE(result.err.find(std::to_string(faults) + " of "), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("--ticks FILE"), std::string::npos) << result.err;
  EXPECT_EQ(kept.code, 5);
  EXPECT_NE(kept.err.find("replay-ticks"), std::string::npos) << kept.err;
  EXPECT_EQ(run({"replay-ticks", kGolden, ticks.path()}).code, 0);
}

TEST(Session, DevicesAreListedWithWhatTheyNeed) {
  const Result result = run({"--list-devices", "--device-library", FAKE_DHD, "--haply-host",
                             "127.0.0.1", "--haply-port", "1"});
  EXPECT_EQ(result.code, 0) << result.err;
  for (const char* line :
       {"simulated  always there", "replay     always there",
        "haply      not there: Haply's service is not there",
        "dhd        there:", "3ds        not there:", "lever      not looked for"}) {
    EXPECT_NE(result.out.find(line), std::string::npos) << line << "\n" << result.out;
  }
  EXPECT_EQ(run({kGolden, "--headless", "--device", "lever"}).code, 2);
  EXPECT_EQ(run({kGolden, "--headless", "--device", "lever", "--lever-line", "/nowhere"}).code, 5);
  EXPECT_EQ(run({kGolden, "--headless", "--device", "dhd", "--fast"}).code, 2);
  EXPECT_EQ(run({kGolden, "--headless", "--device", "falcon"}).code, 2);
}

// A device that keeps the last force until it gets another one.
class Holding final : public device::Device {
 public:
  [[nodiscard]] std::string name() const override { return "holding"; }
  device::RunReport run(const device::ServoFn& servo, std::stop_token /*stop*/) override {
    device::RunReport report;
    for (int n = 0; n < 1500; ++n) {
      device::DeviceState state;
      // Time stands still in the tick that hangs: the safety stage alone could not know.
      state.time_s = 0.001 * n;
      held_n = servo(state).norm();
      if (n > 1001 && n < 1010) after_stall_n.push_back(held_n);
      if (n == 1000) {
        before_stall_n = held_n;
        while (!dropped) std::this_thread::yield();  // hangs until someone takes the force off
      }
      ++report.ticks;
    }
    return report;
  }
  void drop_force() noexcept override {
    held_n = 0;
    dropped = true;
  }
  std::atomic<double> held_n{0};
  std::atomic<bool> dropped{false};
  double before_stall_n = 0;
  std::vector<double> after_stall_n;
};

TEST(HardCase15, AStallTakesTheForceOffAndTheRampBringsItBack) {
  const atlas::Atlas atlas =
      atlas::Atlas::open(kGolden, {.fields = {Structure::Heart}, .surfaces = {}});
  const auto field = std::make_shared<const field::FieldQuery>(atlas.field(Structure::Heart),
                                                               atlas.manifest().rr_interval_s);
  haptics::Servo servo(make_scene(field, {}), {});
  Holding device;
  SessionOptions options;
  options.watchdog = true;
  const Vec3 outward = Vec3::UnitX();
  options.workspace_from_device.translation() =
      field::surface_point_mm(*field, outward, 0) - 6 * outward;
  const Session session = run_session(device, servo, options);
  EXPECT_GE(session.report.stalls, 1);
  EXPECT_GT(device.before_stall_n, 0.2);
  ASSERT_EQ(device.after_stall_n.size(), 8U);
  for (double force : device.after_stall_n) EXPECT_LT(force, 0.05);
  EXPECT_GT(device.held_n, 0.1);
}

}  // namespace
}  // namespace beatlas::app
