#include "runtime/device/lever.h"

#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "runtime/base/error.h"

namespace beatlas::device {
namespace {

TEST(LeverGeometry, TheConversionNeitherMakesNorTakesEnergy) {
  const LeverGeometry lever{.arm_m = 0.08, .zero_rad = 0.3};
  double work_turned = 0;
  double work_straight = 0;
  // A force that depends on the place, over a swing; both works by the midpoint rule.
  constexpr int kSteps = 20000;
  for (int n = 0; n < kSteps; ++n) {
    const double a = -1.0 + 2.4 * (n + 0.5) / kSteps;
    const double da = 2.4 / kSteps;
    const double force = 1 + 5 * lever.displacement_m(a);
    work_turned += lever.torque_n_m(a, force) * da;
    work_straight += force * (lever.displacement_m(a + da / 2) - lever.displacement_m(a - da / 2));
    EXPECT_NEAR(lever.torque_n_m(a, force) * 3.0, force * lever.speed_m_s(a, 3.0), 1e-12);
  }
  EXPECT_NEAR(work_turned, work_straight, 1e-9);
  EXPECT_NEAR(lever.displacement_m(0.3), 0, 1e-15);
}

TEST(LeverGeometry, LessThanFiveGramForceIsNotTransmitted) {
  const LeverGeometry lever;
  EXPECT_EQ(lever.torque_n_m(0, 0.0489), 0);
  EXPECT_EQ(lever.torque_n_m(0, -0.0489), 0);
  EXPECT_NEAR(lever.torque_n_m(0, 0.05), 0.05 * 0.06, 1e-15);
  EXPECT_EQ(lever.torque_n_m(0, std::nan("")), 0);
}

// An axis whose angles are written down.
class Script final : public RotaryAxis {
 public:
  Script(std::vector<double> angles, std::vector<double>& torques)
      : angles_(std::move(angles)), torques_(torques) {}
  bool read(double& angle_rad) noexcept override {
    if (next_ >= angles_.size()) return false;
    angle_rad = angles_[next_++];
    return std::isfinite(angle_rad);
  }
  bool set_torque(double torque_n_m) noexcept override {
    torques_.push_back(torque_n_m);
    return true;
  }

 private:
  std::vector<double> angles_;
  std::size_t next_ = 0;
  std::vector<double>& torques_;
};

TEST(LeverDevice, StraightMotionGoesInAndTorqueComesOut) {
  std::vector<double> torques;
  std::vector<double> angles;
  for (int n = 0; n < 100; ++n) angles.push_back(0.01 * n);
  angles[50] = std::nan("");
  angles[60] = 1.6;  // beyond 80 degrees
  std::vector<Vec3> places;
  std::vector<bool> valid;
  std::string message;
  {
    LeverDevice lever(std::make_unique<Script>(angles, torques),
                      {.direction = Vec3(0, 3, 4), .pace = Pace::Fast, .patience_s = 0.05});
    try {
      (void)lever.run(
          [&](const DeviceState& state) -> Vec3 {
            places.push_back(state.position_m);
            valid.push_back(state.valid);
            return {7, 0.6, 0.8};  // 1 N along the axis; 7 N across it go into the hinge
          },
          {});
      ADD_FAILURE() << "the script ended";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::Machine);
      message = error.what();
    }
  }
  EXPECT_NE(message.find("the lever was lost"), std::string::npos) << message;
  for (std::size_t n = 0; n < 100; ++n) {
    const bool sound = n != 50 && n != 60;
    EXPECT_EQ(valid[n], sound);
    EXPECT_NEAR(torques[n], sound ? 0.06 * std::cos(0.01 * n) : 0, 1e-12);
    if (sound) {
      EXPECT_LT((places[n] - 0.06 * std::sin(0.01 * n) * Vec3(0, 0.6, 0.8)).norm(), 1e-12);
    }
  }
  EXPECT_FALSE(valid.back());
  EXPECT_EQ(torques.back(), 0);
}

// A pseudo terminal stands for the serial line; its other end is the controller.
TEST(LineAxis, SpeaksLinesWithAController) {
  const int controller = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK);
  ASSERT_GE(controller, 0);
  ASSERT_EQ(::grantpt(controller), 0);
  ASSERT_EQ(::unlockpt(controller), 0);
  const auto say = [&](const std::string& text) {
    ASSERT_EQ(::write(controller, text.data(), text.size()), static_cast<ssize_t>(text.size()));
  };
  // The kernel hands bytes over in its own time.
  constexpr int kTries = 5000;
  const auto pause = [] { std::this_thread::sleep_for(std::chrono::milliseconds(1)); };
  {
    LineAxis axis(::ptsname(controller));
    double angle = 9;
    const auto becomes = [&](bool sound, double wanted) {
      for (int n = 0; n < kTries; ++n) {
        if (axis.read(angle) == sound && (!sound || angle == wanted)) return true;
        pause();
      }
      return false;
    };
    EXPECT_FALSE(axis.read(angle));
    say("0.125\n-0.2");
    EXPECT_TRUE(becomes(true, 0.125));
    say("5\r\n");
    EXPECT_TRUE(becomes(true, -0.25));
    // What is no angle is none until the next sound line.
    for (const std::string& bad : {std::string("abc\n"), std::string("nan\n"), std::string("1 2\n"),
                                   std::string("\n"), std::string(300, '1') + "\n"}) {
      say(bad);
      EXPECT_TRUE(becomes(false, 0)) << bad;
      say("0.5\n");
      EXPECT_TRUE(becomes(true, 0.5));
    }
    // A line that goes silent is a cable that is off.
    int reads = 0;
    while (axis.read(angle) && reads < 100) ++reads;
    EXPECT_EQ(reads, 20);
    EXPECT_TRUE(axis.set_torque(-0.0125));
    EXPECT_FALSE(axis.set_torque(1e300));  // longer than any torque
  }
  const std::string expected = "-0.012500\n0.000000\n";  // and zero at the end
  std::string heard;
  for (int n = 0; n < kTries && heard.size() < expected.size(); ++n) {
    std::array<char, 100> part{};
    const ssize_t got = ::read(controller, part.data(), part.size());
    if (got > 0) {
      heard.append(part.data(), static_cast<std::size_t>(got));
    } else {
      pause();
    }
  }
  EXPECT_EQ(heard, expected);
  ::close(controller);
  EXPECT_THROW(LineAxis("/nowhere/tty"), Error);
}

TEST(LeverDevice, RefusesWhatIsNoLever) {
  std::vector<double> torques;
  const auto axis = [&] { return std::make_unique<Script>(std::vector<double>{}, torques); };
  EXPECT_THROW(LeverDevice(nullptr, {}), Error);
  EXPECT_THROW(LeverDevice(axis(), {.direction = Vec3::Zero()}), Error);
  EXPECT_THROW(LeverDevice(axis(), {.geometry = {.arm_m = 0}}), Error);
  EXPECT_THROW(LeverDevice(axis(), {.geometry = {.least_force_n = -1}}), Error);
  EXPECT_THROW(LeverDevice(axis(), {.patience_s = std::nan("")}), Error);
}

}  // namespace
}  // namespace beatlas::device
