#include <chrono>
#include <cmath>
#include <numbers>
#include <sstream>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "runtime/device/csv_table.h"
#include "runtime/device/replay.h"
#include "runtime/device/simulated.h"

namespace beatlas::device {
namespace {

constexpr double kPi = std::numbers::pi;

std::string error_of(const std::string& csv, const std::vector<std::string>& wanted) {
  std::istringstream stream(csv);
  try {
    (void)read_csv(stream, "p.csv", wanted);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
    return error.what();
  }
  return "";
}

TEST(Csv, ReadsColumnsByNameInAnyOrder) {
  std::istringstream stream(
      "\xEF\xBB\xBF"
      "b, note ,a\r\n1e-3,\"x\", +2 \r\n\r\n -4,,5");
  const CsvTable table = read_csv(stream, "p.csv", {"a", "b"});
  EXPECT_EQ(table.header, "b, note ,a");
  EXPECT_EQ(table.columns, (std::vector<std::string>{"b", "note", "a"}));
  ASSERT_EQ(table.rows.size(), 2U);
  EXPECT_EQ(table.rows[0], (std::vector<double>{2, 1e-3}));
  EXPECT_EQ(table.rows[1], (std::vector<double>{5, -4}));
  EXPECT_EQ(table.lines[1], " -4,,5");
}

TEST(Csv, ErrorsNameLineAndColumn) {
  EXPECT_NE(error_of("", {"a"}).find("empty"), std::string::npos);
  EXPECT_NE(error_of("a,c\n1,2\n", {"a", "b"}).find("line 1: column b is missing"),
            std::string::npos);
  EXPECT_NE(error_of("a,a\n1,2\n", {"a"}).find("line 1: column a is there twice"),
            std::string::npos);
  for (const char* bad : {"x", "", "nan", "inf", "1e999", "1 2", "0x10", "1,5"}) {
    const std::string message = error_of(std::string("a,b\n1,2\n\n3,") + bad + "\n", {"a", "b"});
    EXPECT_NE(message.find("p.csv, line 4, column "), std::string::npos) << bad << ": " << message;
  }
  EXPECT_NE(error_of("a,b\n1,2\n3\n", {"a", "b"}).find("line 3, column 2"), std::string::npos);
}

TEST(SimulatedDevice, AMasslessHandFollowsItsPath) {
  SimulatedOptions options;
  options.path = {.anchor_m = Vec3(0.1, 0.2, 0.3),
                  .direction = Vec3(0, 0, -2),
                  .offset_m = 0.002,
                  .amplitude_m = 0.004,
                  .frequency_hz = 1.5};
  options.seconds = 0.5;
  options.pace = Pace::Fast;
  SimulatedDevice device(options);
  int n = 0;
  const RunReport report = device.run(
      [&](const DeviceState& state) -> Vec3 {
        const double t = 0.001 * n++;
        const double w = 2 * kPi * 1.5;
        EXPECT_NEAR(state.time_s, t, 1e-12);
        EXPECT_NEAR(state.position_m.z(), 0.3 - 0.002 - 0.004 * std::sin(w * t), 1e-12);
        EXPECT_NEAR(state.velocity_m_s.z(), -0.004 * w * std::cos(w * t), 1e-12);
        return {100, 0, 0};  // moves nothing
      },
      {});
  EXPECT_EQ(report.ticks, 500);
  EXPECT_EQ(n, 500);
  EXPECT_EQ(report.late_ticks, 0);
}

// Mass, spring and damper under a constant force from rest: the textbook's step response.
double step_response(double m, double k, double c, double force, double t) {
  const double w = std::sqrt(k / m);
  const double zeta = c / (2 * std::sqrt(k * m));
  const double wd = w * std::sqrt(1 - zeta * zeta);
  return force / k *
         (1 - std::exp(-zeta * w * t) * (std::cos(wd * t) + zeta * w / wd * std::sin(wd * t)));
}

TEST(SimulatedDevice, AHeavyHandAnswersAForceLikeTheClosedForm) {
  const auto largest_error = [](double rate_hz) {
    SimulatedOptions options;
    options.hand = {.mass_kg = 0.1, .stiffness_n_per_m = 300, .damping_n_s_per_m = 2};
    options.seconds = 0.5;
    options.rate_hz = rate_hz;
    options.pace = Pace::Fast;
    SimulatedDevice device(options);
    double largest = 0;
    (void)device.run(
        [&](const DeviceState& state) -> Vec3 {
          const double expected = step_response(0.1, 300, 2, 1, state.time_s);
          largest = std::max(largest, std::abs(state.position_m.y() - expected));
          return {0, 1, 0};
        },
        {});
    return largest;
  };
  // The force acts from the first tick on. Of 3.3 mm; second order: (w dt)^2 / 12 a radian.
  EXPECT_LT(largest_error(1000), 3e-6);
  EXPECT_NEAR(largest_error(1000) / largest_error(2000), 4, 0.5);
}

TEST(SimulatedDevice, AStiffHandIsStable) {
  SimulatedOptions options;
  options.hand = {.mass_kg = 0.001, .stiffness_n_per_m = 1e6, .damping_n_s_per_m = 100};
  options.path.amplitude_m = 0.004;
  options.path.frequency_hz = 2;
  options.seconds = 5;
  options.pace = Pace::Fast;
  SimulatedDevice device(options);
  double largest = 0;
  (void)device.run(
      [&](const DeviceState& state) -> Vec3 {
        largest = std::max(largest, state.position_m.norm());
        return Vec3::Zero();
      },
      {});
  EXPECT_LT(largest, 0.0045);
}

TEST(SimulatedDevice, AnEncoderTellsWholeStepsAndVelocitiesOfThem) {
  SimulatedOptions options;
  options.path = {.amplitude_m = 0.004, .frequency_hz = 1};
  options.faults.encoder_step_m = 55e-6;
  options.pace = Pace::Fast;
  SimulatedDevice device(options);
  double largest_velocity = 0;
  (void)device.run(
      [&](const DeviceState& state) -> Vec3 {
        const double exact = 0.004 * std::sin(2 * kPi * state.time_s);
        const double steps = state.position_m.x() / 55e-6;
        EXPECT_NEAR(steps, std::round(steps), 1e-9);
        EXPECT_NEAR(state.position_m.x(), exact, 27.5001e-6);
        largest_velocity = std::max(largest_velocity, std::abs(state.velocity_m_s.x()));
        return Vec3::Zero();
      },
      {});
  // The hand moves at 0.025 m/s at most: a step in one tick is 0.055 m/s.
  EXPECT_NEAR(largest_velocity, 0.055, 1e-9);
}

TEST(SimulatedDevice, AForceActsAfterItsDelay) {
  for (int delay : {0, 1, 7}) {
    SimulatedOptions options;
    options.hand = {.mass_kg = 0.1, .stiffness_n_per_m = 0, .damping_n_s_per_m = 0};
    options.faults.delay_ticks = delay;
    options.seconds = 0.02;
    options.pace = Pace::Fast;
    SimulatedDevice device(options);
    int n = 0;
    int moved = -1;
    (void)device.run(
        [&](const DeviceState& state) -> Vec3 {
          if (moved < 0 && state.position_m.z() > 0) moved = n;
          ++n;
          return {0, 0, 1};
        },
        {});
    EXPECT_EQ(moved, 1 + delay);
  }
}

TEST(SimulatedDevice, DryFrictionHoldsUpToItsForceAndStopsAMovingMass) {
  const auto end_m = [](double force_n, double coulomb_n, double seconds, double push_s) {
    SimulatedOptions options;
    options.hand = {.mass_kg = 0.1, .stiffness_n_per_m = 0, .damping_n_s_per_m = 0};
    options.faults.coulomb_n = coulomb_n;
    options.seconds = seconds;
    options.pace = Pace::Fast;
    SimulatedDevice device(options);
    double x = 0;
    (void)device.run(
        [&](const DeviceState& state) -> Vec3 {
          x = state.position_m.x();
          return {state.time_s < push_s ? force_n : 0, 0, 0};
        },
        {});
    return x;
  };
  EXPECT_EQ(end_m(0.3, 0.31, 1, 1), 0);
  // Pushed for 0.1 s, then slowed: v = (F - f) t / m, way v t / 2 + v^2 m / (2 f).
  const double v = (1 - 0.4) * 0.1 / 0.1;
  EXPECT_NEAR(end_m(1, 0.4, 1, 0.1), v * 0.1 / 2 + v * v * 0.1 / (2 * 0.4), 0.002);
  EXPECT_NEAR(end_m(1, 0.4, 2, 0.1), end_m(1, 0.4, 1, 0.1), 1e-12);
}

TEST(SimulatedDevice, StopsWhenAsked) {
  SimulatedOptions options;
  options.seconds = 1000;
  options.pace = Pace::Fast;
  SimulatedDevice device(options);
  std::stop_source source;
  int n = 0;
  const RunReport report = device.run(
      [&](const DeviceState&) -> Vec3 {
        if (++n == 10) source.request_stop();
        return Vec3::Zero();
      },
      source.get_token());
  EXPECT_EQ(report.ticks, 10);
}

TEST(SimulatedDevice, TimeNeverFallsBehindTheClock) {
  SimulatedOptions options;
  options.seconds = 0.2;
  SimulatedDevice device(options);
  const auto start = std::chrono::steady_clock::now();
  double last = -1;
  bool rises = true;
  const RunReport report = device.run(
      [&](const DeviceState& state) -> Vec3 {
        rises = rises && state.time_s > last;
        last = state.time_s;
        if (state.time_s == 0) std::this_thread::sleep_for(std::chrono::milliseconds(20));
        return Vec3::Zero();
      },
      {});
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  EXPECT_TRUE(rises);
  EXPECT_GE(taken.count(), 0.199);
  EXPECT_GE(report.late_ticks, 1);
  EXPECT_GE(report.worst_late_s, 0.018);
  EXPECT_LE(report.ticks, 182);  // those of the 20 ms are left out, not made up for
}

TEST(SimulatedDevice, RefusesOptionsOutOfRange) {
  SimulatedOptions options;
  options.path.direction = Vec3::Zero();
  EXPECT_THROW(SimulatedDevice{options}, Error);
  options = {};
  options.hand.mass_kg = -1;
  EXPECT_THROW(SimulatedDevice{options}, Error);
  options = {};
  options.faults.delay_ticks = 101;
  EXPECT_THROW(SimulatedDevice{options}, Error);
  options = {};
  options.faults.coulomb_n = std::nan("");
  EXPECT_THROW(SimulatedDevice{options}, Error);
  options = {};
  options.seconds = std::nan("");
  EXPECT_THROW(SimulatedDevice{options}, Error);
}

TEST(Replay, PlaysARecordingLinearlyBetweenItsRows) {
  std::istringstream csv(
      "t_s,x_mm,y_mm,z_mm,depth_mm\n5,0,0,10,0\n5.01,20,0,10,1\n5.014,20,8,10,1\n");
  ReplayDevice device(read_recording(csv, "r.csv"), {.rate_hz = 1000, .pace = Pace::Fast});
  EXPECT_NEAR(device.seconds(), 0.014, 1e-12);
  int n = 0;
  const RunReport report = device.run(
      [&](const DeviceState& state) -> Vec3 {
        const double t = 0.001 * n++;
        EXPECT_NEAR(state.time_s, 5 + t, 1e-12);
        const Vec3 expected_mm(std::min(20.0, 2000 * t), std::max(0.0, 2000 * (t - 0.010)), 10);
        EXPECT_LT((1000 * state.position_m - expected_mm).norm(), 1e-9);
        return Vec3::Zero();
      },
      {});
  EXPECT_EQ(report.ticks, 15);
}

TEST(Replay, RefusesARecordingWhoseTimeDoesNotRise) {
  for (const char* bad : {"t_s,x_mm,y_mm,z_mm\n", "t_s,x_mm,y_mm,z_mm\n1,0,0,0\n1,0,0,0\n"}) {
    std::istringstream csv(bad);
    EXPECT_THROW((void)read_recording(csv, "r.csv"), Error);
  }
  EXPECT_THROW(ReplayDevice({{1, 0}, {Vec3::Zero(), Vec3::Zero()}}, {}), Error);
  EXPECT_THROW(ReplayDevice({}, {}), Error);
}

}  // namespace
}  // namespace beatlas::device
