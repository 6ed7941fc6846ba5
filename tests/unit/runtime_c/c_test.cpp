// The C interface against the C++ one, and what C can do wrong.

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <iterator>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "runtime/atlas/atlas.h"
#include "runtime/c/beatlas.h"
#include "runtime/haptics/cavity_field.h"
#include "runtime/haptics/proxy.h"
#include "runtime/haptics/servo.h"
#include "tests/package/sample_package.h"

namespace beatlas {
namespace {

const char* const kGolden = BEATLAS_GOLDEN_PACKAGE;

struct Session {
  beatlas_session* session;
  explicit Session(const beatlas_options* options = nullptr)
      : session(beatlas_open(kGolden, nullptr, options, nullptr, 0)) {}
  ~Session() { beatlas_close(session); }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
};

beatlas_state state_at(const Session& c, double t, double out_mm) {
  const beatlas_info info = beatlas_get_info(c.session);
  beatlas_state state{};
  state.time_s = t;
  std::copy_n(info.centre_mm, 3, state.position_mm);
  state.position_mm[0] += out_mm;
  state.valid = 1;
  return state;
}

/// The heart of the golden package as C++ has it.
struct GoldenHeart {
  atlas::Atlas atlas = atlas::Atlas::open(kGolden, {.fields = {Structure::Heart}, .surfaces = {}});
  std::shared_ptr<const field::FieldQuery> field = std::make_shared<const field::FieldQuery>(
      atlas.field(Structure::Heart), atlas.manifest().rr_interval_s);

  [[nodiscard]] double stiffness_n_per_m() const { return atlas.manifest().stiffness_n_per_m; }
};

TEST(C, InsideAStructureItsWallIsFeltFromWithin) {
  beatlas_options options = beatlas_default_options();
  options.radius_mm = 1;
  options.inside = 1;
  const Session c(&options);
  ASSERT_NE(c.session, nullptr);
  const GoldenHeart heart;
  haptics::Servo servo(
      {.model = std::make_unique<haptics::ProxyModel>(
           haptics::cavity_of(heart.field),
           haptics::ProxyOptions{.stiffness_n_per_m = heart.stiffness_n_per_m(), .radius_mm = 1}),
       .period_s = heart.field->rr_interval_s()},
      {});
  bool free = false;
  bool touched = false;
  for (int n = 0; n < 2000; ++n) {
    const beatlas_state state = state_at(c, 0.001 * n, 0.02 * n);
    const beatlas_felt felt = beatlas_tick(c.session, &state);
    const haptics::Tick tick =
        servo.tick({.time_s = state.time_s, .position_mm = Vec3(state.position_mm), .valid = true});
    ASSERT_EQ(Vec3(felt.force_n), tick.force_n);
    // Towards the middle, which lies on the other side of the tip.
    ASSERT_LE(felt.force_n[0], 0);
    free = free || (!touched && felt.touching == 0);
    touched = touched || felt.force_n[0] < 0;
  }
  EXPECT_TRUE(free);
  EXPECT_TRUE(touched);
  options.model = BEATLAS_TWO_STEP;
  char message[256];
  EXPECT_EQ(beatlas_open(kGolden, nullptr, &options, message, sizeof message), nullptr);
  EXPECT_NE(std::string(message).find("from within"), std::string::npos) << message;
}

TEST(C, TicksAreThoseOfTheServoToTheBit) {
  beatlas_options options = beatlas_default_options();
  options.radius_mm = 2;
  options.damping_n_s_per_m = 1;
  options.friction_static = 0.5;
  options.friction_dynamic = 0.3;
  options.heart_rate_per_min = 100;
  const Session c(&options);
  ASSERT_NE(c.session, nullptr);
  const GoldenHeart heart;
  haptics::ProxyOptions model;
  model.stiffness_n_per_m = heart.stiffness_n_per_m();
  model.radius_mm = 2;
  model.damping_n_s_per_m = 1;
  model.friction_static = 0.5;
  model.friction_dynamic = 0.3;
  haptics::ServoOptions servo_options;
  servo_options.heart.rate_per_min = 100;
  haptics::Servo servo(haptics::proxy_scene(heart.field, model), servo_options);
  bool touched = false;
  for (int n = 0; n < 2000; ++n) {
    const beatlas_state state = state_at(c, 0.001 * n, 40 - 0.03 * n);
    const beatlas_felt felt = beatlas_tick(c.session, &state);
    const haptics::Tick tick =
        servo.tick({.time_s = state.time_s, .position_mm = Vec3(state.position_mm), .valid = true});
    ASSERT_EQ(Vec3(felt.force_n), tick.force_n);
    ASSERT_EQ(felt.distance_mm, tick.contact.distance_mm);
    ASSERT_EQ(static_cast<int>(felt.status), static_cast<int>(tick.status));
    touched = touched || felt.touching != 0;
    const beatlas_seen seen = beatlas_look(c.session);
    ASSERT_EQ(seen.ticks, static_cast<std::uint64_t>(n + 1));
    ASSERT_EQ(seen.force_n[0], felt.force_n[0]);
  }
  EXPECT_TRUE(touched);
}

TEST(C, TaxelsHoldTheForceOfTheNewestTick) {
  beatlas_options options = beatlas_default_options();
  options.radius_mm = 3;
  const Session c(&options);
  ASSERT_NE(c.session, nullptr);
  char message[256];
  beatlas_taxel_map map{};
  ASSERT_EQ(beatlas_taxels(c.session, nullptr, &map, message, sizeof message), 1) << message;
  EXPECT_EQ(map.area_mm2, 0);
  beatlas_felt felt{};
  for (int n = 0; n < 2000; ++n) {  // 60 mm out to 5 mm out, through the surface
    const beatlas_state state = state_at(c, 0.001 * n, 60 - 0.0275 * n);
    felt = beatlas_tick(c.session, &state);
    if (felt.touching != 0 && felt.distance_mm < -1) break;
  }
  ASSERT_NE(felt.touching, 0);
  const double up[3] = {0, 0, 1};
  ASSERT_EQ(beatlas_taxels(c.session, up, &map, message, sizeof message), 1) << message;
  double force_n = 0;
  for (const double kpa : map.pressure_kpa) force_n += kpa * map.pitch_mm * map.pitch_mm / 1000;
  const Vec3 force(felt.force_n);
  EXPECT_NEAR(force_n, force.dot(Vec3(felt.normal)), 0.01 * force.norm());
  EXPECT_GT(force_n, 0);
  EXPECT_GT(map.area_mm2, 0);
  EXPECT_GE(map.peak_kpa,
            *std::max_element(std::begin(map.pressure_kpa), std::end(map.pressure_kpa)));
  EXPECT_GT(Vec3(map.right).z(), 0);
  EXPECT_NEAR(Vec3(map.right).cross(Vec3(map.up)).dot(-Vec3(felt.normal)), -1, 1e-9);

  EXPECT_EQ(beatlas_taxels(nullptr, nullptr, &map, message, sizeof message), 0);
  EXPECT_EQ(beatlas_taxels(c.session, nullptr, nullptr, message, sizeof message), 0);
  options.model = BEATLAS_TWO_STEP;
  const Session two_step(&options);
  EXPECT_EQ(beatlas_taxels(two_step.session, nullptr, &map, message, sizeof message), 0);
  EXPECT_NE(std::string(message).find("BEATLAS_PROXY"), std::string::npos);
}

TEST(C, TaxelsOfAFingertipHoldTheForceOfTheNewestTick) {
  for (const int inside : {0, 1}) {
    beatlas_options options = beatlas_default_options();
    options.model = BEATLAS_FINGERTIP;
    options.radius_mm = 3;
    options.inside = inside;
    const Session c(&options);
    ASSERT_NE(c.session, nullptr);
    char message[256];
    beatlas_taxel_map map{};
    ASSERT_EQ(beatlas_taxels(c.session, nullptr, &map, message, sizeof message), 1) << message;
    EXPECT_EQ(map.area_mm2, 0);
    EXPECT_NEAR(map.pitch_mm, 0.75, 1e-12);
    beatlas_felt felt{};
    for (int n = 0; n < 2000; ++n) {  // 60 mm out to the middle, or from there outwards
      beatlas_state state = state_at(c, 0.001 * n, inside != 0 ? 0.03 * n : 60 - 0.03 * n);
      // The tip's -z is along x: towards the wall from where it comes.
      state.orientation[1] = (inside != 0 ? -1 : 1) * std::sqrt(0.5);
      state.orientation[3] = std::sqrt(0.5);
      felt = beatlas_tick(c.session, &state);
      if (felt.touching != 0 && felt.distance_mm < -1) break;
    }
    ASSERT_NE(felt.touching, 0) << inside;
    ASSERT_EQ(beatlas_swap(c.session, kGolden, message, sizeof message), 1) << message;
    ASSERT_EQ(beatlas_taxels(c.session, nullptr, &map, message, sizeof message), 1) << message;
    double force_n = 0;
    for (const double kpa : map.pressure_kpa) force_n += kpa * map.pitch_mm * map.pitch_mm / 1000;
    const double felt_n = Vec3(felt.force_n).dot(Vec3(felt.normal));
    EXPECT_NEAR(force_n, felt_n, 0.01 * felt_n) << inside;
    EXPECT_GT(force_n, 0) << inside;
    EXPECT_GT(map.area_mm2, 0) << inside;
    EXPECT_GE(map.peak_kpa,
              *std::max_element(std::begin(map.pressure_kpa), std::end(map.pressure_kpa)));
  }
}

TEST(C, ToolsOnOneHeartFeelWhatEachFeelsAlone) {
  const Session first;
  char message[256];
  beatlas_options options = beatlas_default_options();
  options.radius_mm = 3;
  beatlas_session* second = beatlas_open_beside(first.session, &options, message, sizeof message);
  ASSERT_NE(second, nullptr) << message;
  const Session alone(&options);
  double most_n = 0;
  for (int n = 0; n < 2000; ++n) {
    const beatlas_state left = state_at(first, 0.001 * n, 60 - 0.0275 * n);
    const beatlas_state right = state_at(first, 0.001 * n, -60 + 0.0275 * n);
    (void)beatlas_tick(first.session, &left);
    const beatlas_felt beside = beatlas_tick(second, &right);
    const beatlas_felt by_itself = beatlas_tick(alone.session, &right);
    for (int a = 0; a < 3; ++a) ASSERT_EQ(beside.force_n[a], by_itself.force_n[a]) << n;
    most_n = std::max(most_n, Vec3(beside.force_n).norm());
  }
  EXPECT_GT(most_n, 0);
  EXPECT_EQ(beatlas_look(first.session).phase, beatlas_look(second).phase);
  beatlas_close(second);
  EXPECT_EQ(beatlas_open_beside(nullptr, nullptr, message, sizeof message), nullptr);
  EXPECT_NE(std::string(message).find("no session"), std::string::npos);
}

TEST(C, QueriesAreTheFields) {
  const Session c;
  const atlas::Atlas atlas =
      atlas::Atlas::open(kGolden, {.fields = {Structure::Heart}, .surfaces = {}});
  const field::FieldQuery field(atlas.field(Structure::Heart), atlas.manifest().rr_interval_s);
  const beatlas_info info = beatlas_get_info(c.session);
  EXPECT_EQ(info.phases, field.phases());
  EXPECT_EQ(Vec3(info.centre_mm), field.centre_mm());
  EXPECT_EQ(info.workspace_from_lps[3], atlas.manifest().workspace_from_lps(0, 3));
  const double points[6] = {info.centre_mm[0] + 15, info.centre_mm[1], info.centre_mm[2],
                            info.centre_mm[0],      info.centre_mm[1], info.centre_mm[2] - 500};
  double distances[2];
  double normals[6];
  beatlas_query(c.session, points, 2, 0.3, distances, normals);
  for (int n = 0; n < 2; ++n) {
    const Vec3 x(points + 3 * n);
    const field::FieldSample sample = field.sample(x, 0.3 * info.rr_interval_s);
    EXPECT_EQ(distances[n], sample.distance_mm);
    EXPECT_EQ(Vec3(normals + 3 * n), field.normal(sample, x));
  }
  beatlas_query(c.session, points, 2, 0.3, nullptr, nullptr);
}

TEST(C, HowWellTheSurfaceIsKnownIsThePackages) {
  const test::TemporaryFolder folder;
  pack::PackageContent content = test::tiny_content();
  const auto slices = static_cast<std::size_t>(content.manifest.source_size[2]);
  const auto everywhere = [&](double mm) {
    return std::vector(4, std::vector<double>(slices, mm));
  };
  content.manifest.structures.front().band = {everywhere(1), everywhere(5)};
  const std::filesystem::path file = folder.path() / "banded.beatlas";
  pack::write_package(file, content);
  char message[256];
  beatlas_session* session = beatlas_open(file.c_str(), nullptr, nullptr, message, sizeof message);
  ASSERT_NE(session, nullptr) << message;
  const beatlas_info info = beatlas_get_info(session);
  const double r = 10 / std::sqrt(2.0);
  const double points[9] = {info.centre_mm[0] + 10, info.centre_mm[1], info.centre_mm[2],
                            info.centre_mm[0],      info.centre_mm[1], info.centre_mm[2] - 10,
                            info.centre_mm[0] + r,  info.centre_mm[1], info.centre_mm[2] + r};
  double widths[3];
  double normals[9];
  beatlas_query(session, points, 3, 0.25, nullptr, normals);
  ASSERT_EQ(beatlas_known_within(session, points, 3, 0.25, widths, message, sizeof message), 1)
      << message;
  for (int n = 0; n < 3; ++n) {  // the sample's slices lie along z
    const double along = std::abs(normals[3 * n + 2]);
    EXPECT_NEAR(widths[n], std::sqrt(1 - along * along) + 5 * along, 1e-9) << n;
  }
  EXPECT_LT(widths[0], widths[2]);
  EXPECT_EQ(beatlas_known_within(session, points, 3, 0, nullptr, message, sizeof message), 0);
  for (const double no_number : {std::nan(""), double(INFINITY)}) {
    double bad[9];
    std::copy_n(points, 9, bad);
    bad[4] = no_number;
    widths[0] = -1;
    EXPECT_EQ(beatlas_known_within(session, bad, 3, 0.25, widths, message, sizeof message), 0);
    EXPECT_STREQ(message, "point 1, counted from 0, must be three numbers in mm");
    EXPECT_EQ(widths[0], -1) << "nothing is written";
    EXPECT_EQ(beatlas_known_within(session, points, 3, no_number, widths, message, sizeof message),
              0);
    EXPECT_NE(std::string(message).find("phase"), std::string::npos) << message;
  }
  beatlas_close(session);
  EXPECT_EQ(beatlas_known_within(nullptr, points, 3, 0, widths, nullptr, 0), 0);
  const Session golden;
  EXPECT_EQ(beatlas_known_within(golden.session, points, 3, 0, widths, message, sizeof message), 0);
  EXPECT_NE(std::string(message).find("does not tell how well"), std::string::npos);
}

TEST(C, EveryModelOpensAndWhatIsNotThereIsSaid) {
  for (beatlas_model model :
       {BEATLAS_PROXY, BEATLAS_TWO_STEP, BEATLAS_PUBLISHED, BEATLAS_FINGERTIP}) {
    beatlas_options options = beatlas_default_options();
    options.model = model;
    options.start_ramp_s = 0;
    const Session c(&options);
    ASSERT_NE(c.session, nullptr);
    double most = 0;
    for (int n = 0; n < 1500; ++n) {
      const beatlas_state state = state_at(c, 0.001 * n, 45 - 0.03 * n);
      most = std::max(most, std::abs(beatlas_tick(c.session, &state).force_n[0]));
    }
    EXPECT_GT(most, 0.1) << model;
  }
  char message[200] = "x";
  EXPECT_EQ(beatlas_open("/nowhere.beatlas", nullptr, nullptr, message, sizeof message), nullptr);
  EXPECT_NE(std::strstr(message, "nowhere.beatlas"), nullptr) << message;
  EXPECT_EQ(beatlas_open(kGolden, "liver", nullptr, message, sizeof message), nullptr);
  EXPECT_STREQ(message, "there is no structure liver");
  char small[6];
  EXPECT_EQ(beatlas_open(kGolden, "liver", nullptr, small, sizeof small), nullptr);
  EXPECT_STREQ(small, "there");
  EXPECT_EQ(beatlas_open(nullptr, nullptr, nullptr, message, sizeof message), nullptr);
  beatlas_options options = beatlas_default_options();
  options.peak_n = 1e6;
  EXPECT_EQ(beatlas_open(kGolden, nullptr, &options, message, sizeof message), nullptr);
  EXPECT_NE(std::strstr(message, "peak_n"), nullptr) << message;
  options = beatlas_default_options();
  const int none_such = 9;
  std::memcpy(&options.model, &none_such, sizeof(none_such));
  EXPECT_EQ(beatlas_open(kGolden, nullptr, &options, message, sizeof message), nullptr);
}

TEST(C, NullAndStatesThatAreNoneGiveZeroForce) {
  EXPECT_EQ(beatlas_tick(nullptr, nullptr).status, BEATLAS_FAULT);
  EXPECT_EQ(beatlas_look(nullptr).status, BEATLAS_FAULT);
  EXPECT_EQ(beatlas_get_info(nullptr).phases, 0);
  EXPECT_EQ(beatlas_swap(nullptr, kGolden, nullptr, 0), 0);
  beatlas_close(nullptr);
  beatlas_set_heart_rate(nullptr, 60);
  beatlas_set_paused(nullptr, 1);
  EXPECT_EQ(beatlas_hold_phase(nullptr, 0), 0);
  beatlas_stop(nullptr);
  beatlas_restart(nullptr);
  const Session c;
  const beatlas_state inside = state_at(c, 0, 0);
  EXPECT_EQ(beatlas_tick(c.session, nullptr).status, BEATLAS_FAULT);
  for (int n = 0; n < 6; ++n) {
    beatlas_state bad = inside;
    if (n < 3) bad.position_mm[n] = std::nan("");
    if (n == 3) bad.time_s = INFINITY;
    if (n == 4) bad.orientation[2] = std::nan("");
    if (n == 5) bad.valid = 0;
    const beatlas_felt felt = beatlas_tick(c.session, &bad);
    EXPECT_EQ(felt.status, BEATLAS_FAULT) << n;
    EXPECT_EQ(Vec3(felt.force_n), Vec3::Zero());
  }
}

TEST(C, APhaseToHoldIsAShareOfTheCycle) {
  const Session c;
  const auto phase_after = [&](double from_s) {
    for (int n = 0; n < 4000; ++n) {
      const beatlas_state state = state_at(c, from_s + 0.001 * n, 80);
      (void)beatlas_tick(c.session, &state);
    }
    return beatlas_look(c.session).phase;
  };
  ASSERT_EQ(beatlas_hold_phase(c.session, 0.3), 1);
  EXPECT_NEAR(phase_after(0), 0.3, 1e-6);
  for (const double none : {7.0, 1.001, double(INFINITY), std::nan("")}) {
    EXPECT_EQ(beatlas_hold_phase(c.session, none), 0) << none;
  }
  EXPECT_NEAR(phase_after(4), 0.3, 1e-6) << "what was refused changes nothing";
  EXPECT_EQ(beatlas_hold_phase(c.session, -1), 1);
  EXPECT_NE(phase_after(8), phase_after(12));
}

TEST(C, AClockThatStandsStillHoldsNoForce) {
  beatlas_options options = beatlas_default_options();
  options.radius_mm = 3;
  const Session c(&options);
  ASSERT_NE(c.session, nullptr);
  beatlas_felt felt{};
  for (int n = 0; n <= 2000; ++n) {
    const beatlas_state state = state_at(c, 0.001 * n, 45 - 0.02 * n);
    felt = beatlas_tick(c.session, &state);
  }
  ASSERT_GT(Vec3(felt.force_n).norm(), 0.1);
  const beatlas_state away = state_at(c, 2, 300);  // the tool has left, the clock has not
  felt = beatlas_tick(c.session, &away);
  EXPECT_NE(felt.status, BEATLAS_FAULT);
  for (int n = 0; n < 100; ++n) {
    felt = beatlas_tick(c.session, &away);
    ASSERT_EQ(felt.status, BEATLAS_FAULT) << n;
    ASSERT_EQ(Vec3(felt.force_n), Vec3::Zero()) << n;
  }
  const beatlas_state on = state_at(c, 2.001, 300);
  EXPECT_NE(beatlas_tick(c.session, &on).status, BEATLAS_FAULT);
}

TEST(C, AnotherThreadSteersTheHeartAndSwapsThePackage) {
  const Session c;
  const beatlas_state start = state_at(c, 0, 20);
  std::atomic<bool> done{false};
  std::atomic<double> largest{0};
  std::thread servo([&] {
    for (int n = 0; !done; ++n) {
      beatlas_state state = start;
      state.time_s = 0.001 * n;
      const beatlas_felt felt = beatlas_tick(c.session, &state);
      largest = std::max<double>(largest, Vec3(felt.force_n).norm());
    }
  });
  char message[200];
  for (int n = 0; n < 5; ++n) {
    beatlas_set_heart_rate(c.session, 60 + n);
    beatlas_hold_phase(c.session, n == 3 ? 0.2 : -1);
    EXPECT_EQ(beatlas_swap(c.session, kGolden, message, sizeof message), 1) << message;
    const std::uint64_t ticks = beatlas_look(c.session).ticks;
    while (beatlas_look(c.session).ticks < ticks + 10) std::this_thread::yield();
  }
  EXPECT_EQ(beatlas_swap(c.session, "/nowhere.beatlas", message, sizeof message), 0);
  done = true;
  servo.join();
  EXPECT_LE(largest, 3 + 1e-9);
}

}  // namespace
}  // namespace beatlas
