// The devices of vendors' libraries, by libraries of ours that export the same functions.

#include <cmath>
#include <cstdlib>
#include <functional>
#include <string>

#include <dlfcn.h>
#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "runtime/device/force_dimension.h"
#include "runtime/device/open_haptics.h"

namespace beatlas::device {
namespace {

// Environment that says what goes wrong, for one scope.
class Fault {
 public:
  Fault(const char* name, const char* value) : name_(name) { ::setenv(name, value, 1); }
  ~Fault() { ::unsetenv(name_); }
  Fault(const Fault&) = delete;
  Fault& operator=(const Fault&) = delete;

 private:
  const char* name_;
};

// The same library as the device's, to look behind it.
template <class Function>
Function* behind(const char* library, const char* name) {
  void* const handle = ::dlopen(library, RTLD_NOW | RTLD_LOCAL);
  EXPECT_NE(handle, nullptr) << ::dlerror();
  return reinterpret_cast<Function*>(::dlsym(handle, name));
}

std::string error_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::Machine);
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return "";
}

void expect_words(const std::string& message, const std::string& words) {
  EXPECT_NE(message.find(words), std::string::npos) << message;
}

TEST(OpenHaptics, TheVendorsSchedulerCallsTheServoInSi) {
  auto* const last_force = behind<double(int)>(FAKE_HD, "fake_last_force");
  auto* const open = behind<int()>(FAKE_HD, "fake_open");
  {
    OpenHapticsDevice device({.library = FAKE_HD, .device_name = "Right"});
    EXPECT_EQ(open(), 1);
    std::stop_source source;
    int n = 0;
    double last_s = -1;
    const RunReport report = device.run(
        [&](const DeviceState& state) -> Vec3 {
          ++n;
          EXPECT_TRUE(state.valid);
          EXPECT_GT(state.time_s, last_s);
          last_s = state.time_s;
          EXPECT_NEAR(state.position_m.x(), 0.010 + 0.001 * n, 1e-12);
          EXPECT_NEAR(state.position_m.z(), 0.030 + 0.001 * n, 1e-12);
          EXPECT_LT((state.velocity_m_s - Vec3(0.1, 0.2, 0.3)).norm(), 1e-12);
          EXPECT_EQ(state.buttons, 2U);
          if (n > 1) {  // what the tick before gave went to the device
            EXPECT_DOUBLE_EQ(last_force(0), 0.5 * (n - 1));
            EXPECT_DOUBLE_EQ(last_force(2), -1);
          }
          if (n == 40) source.request_stop();
          return {0.5 * n, 0, -1};
        },
        source.get_token());
    EXPECT_GE(report.ticks, 40);
  }
  EXPECT_EQ(open(), 0);
}

TEST(OpenHaptics, NoNumberAndADroppedForceAreZero) {
  auto* const last_force = behind<double(int)>(FAKE_HD, "fake_last_force");
  OpenHapticsDevice device({.library = FAKE_HD, .device_name = {}});
  std::stop_source source;
  int n = 0;
  (void)device.run(
      [&](const DeviceState&) -> Vec3 {
        ++n;
        if (n == 11 || n == 21) {
          EXPECT_EQ(last_force(0), 0);
        } else if (n > 1) {
          EXPECT_EQ(last_force(0), 1);
        }
        if (n == 20) device.drop_force();
        if (n == 30) source.request_stop();
        return {n == 10 ? std::nan("") : 1, 0, 0};
      },
      source.get_token());
  EXPECT_GE(n, 30);
}

TEST(OpenHaptics, AbsentOrLostIsASentenceAndZeroForce) {
  expect_words(error_of([] { OpenHapticsDevice device({.library = "/nowhere/libHD.so"}); }),
               "OpenHaptics of 3D Systems is not installed (/nowhere/libHD.so");
  expect_words(error_of([] { OpenHapticsDevice device({.library = FAKE_DHD}); }),
               "exports no hdInitDevice");
  {
    const Fault absent("FAKE_HD", "absent");
    expect_words(error_of([] { OpenHapticsDevice device({.library = FAKE_HD}); }),
                 "cannot be opened (HD error 770)");
  }
  {
    const Fault stuck("FAKE_HD", "stuck");
    OpenHapticsDevice device({.library = FAKE_HD});
    expect_words(
        error_of([&] { (void)device.run([](const DeviceState&) { return Vec3(1, 0, 0); }, {}); }),
        "scheduler does not start");
  }
  auto* const last_force = behind<double(int)>(FAKE_HD, "fake_last_force");
  const Fault lost("FAKE_HD", "lost");
  OpenHapticsDevice device({.library = FAKE_HD});
  int invalid = 0;
  const std::string message = error_of([&] {
    (void)device.run(
        [&](const DeviceState& state) -> Vec3 {
          if (!state.valid) ++invalid;
          if (invalid > 1) {
            EXPECT_EQ(last_force(0), 0);
          }
          return {1, 0, 0};
        },
        {});
  });
  expect_words(message, "was lost");
  EXPECT_GE(invalid, 100);
}

TEST(ForceDimension, ALoopOfOursTurnsItsAxes) {
  auto* const force = behind<double(int)>(FAKE_DHD, "fake_force");
  auto* const opened = behind<int()>(FAKE_DHD, "fake_opened");
  {
    ForceDimensionDevice device({.library = FAKE_DHD, .rate_hz = 2000});
    EXPECT_EQ(opened(), 1);
    std::stop_source source;
    int n = 0;
    (void)device.run(
        [&](const DeviceState& state) -> Vec3 {
          EXPECT_TRUE(state.valid);
          // Theirs: towards the user, right, up. Ours: right, up, towards the user.
          EXPECT_EQ(state.position_m, Vec3(0.02, 0.03, 0.01));
          EXPECT_EQ(state.velocity_m_s, Vec3(0.2, 0.3, 0.1));
          EXPECT_EQ(state.buttons, 9U);
          if (n == 11) {
            EXPECT_EQ(force(1), 0);  // of no number
          } else if (n > 0) {
            EXPECT_EQ(Vec3(force(0), force(1), force(2)), Vec3(3, 1, 2));
          }
          if (++n == 20) source.request_stop();
          return n == 11 ? Vec3(std::nan(""), 0, 0) : Vec3(1, 2, 3);
        },
        source.get_token());
    EXPECT_EQ(force(0), 0);  // after the end
  }
  EXPECT_EQ(opened(), 0);
}

TEST(ForceDimension, AbsentOrLostIsASentenceAndZeroForce) {
  expect_words(error_of([] { ForceDimensionDevice device({.library = "/nowhere/libdhd.so"}); }),
               "the SDK of Force Dimension is not installed");
  {
    const Fault absent("FAKE_DHD", "absent");
    expect_words(error_of([] { ForceDimensionDevice device({.library = FAKE_DHD}); }),
                 "(no device found)");
  }
  auto* const force = behind<double(int)>(FAKE_DHD, "fake_force");
  const Fault lost("FAKE_DHD", "lost");
  ForceDimensionDevice device({.library = FAKE_DHD});
  int invalid = 0;
  const std::string message = error_of([&] {
    (void)device.run(
        [&](const DeviceState& state) -> Vec3 {
          if (!state.valid && ++invalid > 1) {
            EXPECT_EQ(force(0), 0);
          }
          return {0, 0, 1};
        },
        {});
  });
  expect_words(message, "was lost");
  EXPECT_GE(invalid, 1);
  EXPECT_EQ(force(0), 0);
  EXPECT_THROW(ForceDimensionDevice({.library = FAKE_DHD, .rate_hz = 1e6}), Error);
}

}  // namespace
}  // namespace beatlas::device
