/// The servo's thread without a window: devices that end, are lost, or stall; times of ticks.

#include "runtime/viewer/live_touch.h"

#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <thread>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "runtime/viewer/stills.h"
#include "runtime/viewer/tick_times.h"
#include "tests/package/sample_package.h"

namespace beatlas::viewer {
namespace {

TEST(TickTimes, QuantilesAreThoseOfWhatWasAdded) {
  TickTimes times;
  EXPECT_EQ(times.quantile_us(0.5), 0);
  for (int n = 1; n <= 1000; ++n) times.add(1000 * n);  // 1 us .. 1 ms
  EXPECT_EQ(times.count(), 1000U);
  for (const double share : {0.01, 0.5, 0.99, 0.999, 1.0}) {
    const double found = times.quantile_us(share);
    EXPECT_GE(found, 1000 * share);
    EXPECT_LE(found, 1000 * share * 1.06) << "a step is a twelfth of an octave";
  }
  times.add(-5);              // a clock that went back
  times.add(40'000'000'000);  // longer than it knows
  EXPECT_EQ(times.count(), 1002U);
  times.clear();
  EXPECT_EQ(times.count(), 0U);
}

// A hand 3 mm deep in the heart, for some ticks; then what `end` does.
class StillHand final : public device::Device {
 public:
  StillHand(const Vec3& at_mm, std::function<void()> end) : at_mm_(at_mm), end_(std::move(end)) {}
  [[nodiscard]] std::string name() const override { return "still"; }
  device::RunReport run(const device::ServoFn& servo, std::stop_token stop) override {
    device::RunReport report;
    for (; report.ticks < 1000 && !stop.stop_requested(); ++report.ticks) {
      device::DeviceState state;
      state.time_s = 1e-3 * static_cast<double>(report.ticks);
      state.position_m = 1e-3 * at_mm_;
      felt_n = servo(state).norm();
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
    if (!stop.stop_requested()) end_();
    return report;
  }
  static inline std::atomic<double> felt_n = 0;

 private:
  Vec3 at_mm_;
  std::function<void()> end_;
};

class Live : public testing::Test {
 protected:
  void SetUp() override {
    const std::filesystem::path file = folder_.path() / "heart.beatlas";
    pack::write_package(file, test::sample_content(6, 45, 2, 3));
    heart_ = open_heart(file);
    middle_mm_ = heart_.field->centre_mm();
    double out_mm = 0;
    while (heart_.field->sample(middle_mm_ + Vec3(out_mm, 0, 0), 0).distance_mm < -3) ++out_mm;
    inside_mm_ = middle_mm_ + Vec3(out_mm, 0, 0);
  }
  [[nodiscard]] std::unique_ptr<LiveTouch> live() const {
    return std::make_unique<LiveTouch>(
        std::make_unique<Touch>(heart_.atlas->manifest(), heart_.field, TouchSettings{}),
        middle_mm_ + Vec3(200, 0, 0));
  }
  static std::string trouble(LiveTouch& live) {
    for (int n = 0; n < 1000; ++n) {
      std::string told = live.take_trouble();
      if (!told.empty()) return told;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return {};
  }

  test::TemporaryFolder folder_;
  OpenedHeart heart_;
  Vec3 middle_mm_;
  Vec3 inside_mm_;
};

// A finger that stays 3 mm deep, whatever is changed under it.
struct StillFinger {
  Touch touch;
  Vec3 at_mm;
  double time_s = 0;
  Vec3 before_n = Vec3::Zero();
  double largest_step_n = 0;
  int faults = 0;

  /// Mean force over the second half of some ticks.
  double feel(int ticks) {
    double sum_n = 0;
    for (int n = 0; n < ticks; ++n) {
      time_s += 1e-3;
      const Vec3 force_n = touch.tick({.time_s = time_s, .position_mm = at_mm});
      faults += touch.felt().servo.status == haptics::TickStatus::Fault ? 1 : 0;
      largest_step_n = std::max(largest_step_n, (force_n - before_n).norm());
      before_n = force_n;
      if (n >= ticks / 2) sum_n += force_n.norm() / (ticks - ticks / 2);
    }
    return sum_n;
  }
};

constexpr double kSlewN = 0.05 + 1e-9;  // 5 gf: the slew's limit of 50 N/s, in a tick

TEST_F(Live, TheAtriumsPressureIsFeltWhileItChanges) {
  const auto finger = [&](const std::string& preset) {
    return StillFinger{.touch{heart_.atlas->manifest(), heart_.field,
                              TouchSettings{.model = "patch", .preset = preset}},
                       .at_mm = inside_mm_};
  };
  StillFinger healthy = finger("healthy");
  const double healthy_n = healthy.feel(6000);
  StillFinger low = finger("low_pressure");
  EXPECT_LT(low.feel(6000), 0.9 * healthy_n);
  healthy.touch.set_left_atrial_mmhg(3);
  EXPECT_LT(healthy.feel(6000), 0.9 * healthy_n);
  healthy.touch.set_left_atrial_mmhg(20);
  EXPECT_GT(healthy.feel(6000), 1.2 * healthy_n);
  EXPECT_LE(healthy.largest_step_n, kSlewN) << "a change is no blow";
  EXPECT_EQ(healthy.faults, 0);
}

TEST_F(Live, ASettingUnderTheFingerNeitherDropsTheForceNorForgetsTheDent) {
  for (const char* model : {"proxy", "patch"}) {
    StillFinger finger{.touch{heart_.atlas->manifest(), heart_.field, {.model = model}},
                       .at_mm = inside_mm_};
    Touch& touch = finger.touch;
    EXPECT_GT(finger.feel(4000), 0.1) << model;
    const std::vector<std::function<void()>> changes{
        [&] { touch.set_heart_rate(touch.settings().heart_rate_per_min + 1); },
        [&] { touch.set_left_atrial_mmhg(10); },
        [&] { touch.set_constant("muscle/middle/k_v_n_per_m", 76); },
        [&] { touch.set_stiffness(touch.settings().stiffness_n_per_m + 1); }};
    for (const auto& change : changes) {
      change();
      (void)finger.feel(1000);
    }
    EXPECT_LE(finger.largest_step_n, kSlewN) << model;
    EXPECT_EQ(finger.faults, 0) << model;
    // Another kind of model is another contact.
    touch.set_model(std::string(model) == "proxy" ? "patch" : "proxy");
    (void)finger.feel(100);
    EXPECT_EQ(finger.faults, 1) << model;
  }
}

TEST_F(Live, TheDentIsThatOfThePresetWheneverItIsChosen) {
  const auto radius_mm = [](const Touch& touch) { return touch.tool_picture({}).dent_radius_mm; };
  Touch touch(heart_.atlas->manifest(), heart_.field, TouchSettings{.model = "patch"});
  const double healthy_mm = radius_mm(touch);
  for (const char* preset : {"by_74_percent", "healthy"}) {
    const Touch begun(heart_.atlas->manifest(), heart_.field,
                      TouchSettings{.model = "patch", .preset = preset});
    touch.set_preset(preset);
    EXPECT_NEAR(radius_mm(touch), radius_mm(begun), 1e-9) << preset;
  }
  touch.set_constant("circulation/contact_area_cm2", 20);
  EXPECT_GT(std::abs(radius_mm(touch) - healthy_mm), 0.1);
}

TEST_F(Live, TellsHowWellIsKnownWhatIsTouched) {
  atlas::Manifest manifest = heart_.atlas->manifest();
  const auto pressed = [&] {
    Touch touch(manifest, heart_.field, {});
    (void)touch.tick({.time_s = 0, .position_mm = inside_mm_});
    return touch.known_to_mm(touch.felt(0));
  };
  manifest.structures[0].band.reset();
  EXPECT_FALSE(pressed().has_value());
  // As well along the slices as across them: at any place between the two together.
  manifest.source_size = {8, 8, 3};
  const std::vector table(static_cast<std::size_t>(manifest.phase_count()),
                          std::vector<double>(3, 2));
  manifest.structures[0].band = {table, table};
  const auto known_mm = pressed();
  ASSERT_TRUE(known_mm.has_value());
  EXPECT_GE(*known_mm, 2 - 1e-9);
  EXPECT_LE(*known_mm, 2 * std::sqrt(2) + 1e-9);
}

TEST_F(Live, EveryConstantChangesWhileItRuns) {
  Touch touch(heart_.atlas->manifest(), heart_.field, TouchSettings{.model = "patch"});
  double time_s = 0;
  const auto felt = [&] {  // mean force over the second half of some seconds
    double sum_n = 0;
    constexpr int kTicks = 4000;
    for (int n = 0; n < kTicks; ++n) {
      time_s += 1e-3;
      const double force_n = touch.tick({.time_s = time_s, .position_mm = inside_mm_}).norm();
      if (n >= kTicks / 2) sum_n += force_n / (kTicks / 2);
    }
    return sum_n;
  };
  const std::vector<std::string> names = touch.constants();
  EXPECT_GT(names.size(), 35U);
  for (const std::string& name : names) EXPECT_NO_THROW((void)touch.constant(name)) << name;
  const double before_n = felt();
  EXPECT_EQ(touch.constant("muscle/middle/k_v_n_per_m"), 75);
  touch.set_constant("muscle/middle/k_v_n_per_m", 150);
  EXPECT_GT(felt(), 1.2 * before_n);
  touch.set_constant("muscle/middle/k_v_n_per_m", 75);
  EXPECT_NEAR(felt(), before_n, 0.06 * before_n);  // a mean over no whole number of beats
  // A weight scales what goes with it.
  const double resistance = touch.constant("circulation/resistance_mmhg_s_per_ml");
  const double weight_kg = touch.constant("circulation/weight_kg");
  touch.set_constant("circulation/weight_kg", 2 * weight_kg);
  EXPECT_NEAR(touch.constant("circulation/resistance_mmhg_s_per_ml"),
              resistance * std::pow(2, -0.75), 1e-9 * resistance);
  touch.set_constant("circulation/heart_rate_per_min", 90);
  EXPECT_EQ(touch.settings().heart_rate_per_min, 90);
  const auto refusal = [&](const std::string& name, double value) -> std::string {
    try {
      touch.set_constant(name, value);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(refusal("circulation/left_atrial_mmhg", 41).find("0 to 40"), std::string::npos);
  EXPECT_NE(refusal("circulation/weight_kg", 0).find("1 to 500"), std::string::npos);
  EXPECT_NE(refusal("circulation/colour", 1).find("no constant"), std::string::npos);
  EXPECT_EQ(touch.constant("circulation/left_atrial_mmhg"), 9) << "a refusal changes nothing";
}

TEST_F(Live, ADeviceThatEndsLeavesTheToolToTheMouse) {
  const auto live = this->live();
  live->use({.device = std::make_unique<StillHand>(inside_mm_, [] {})});
  EXPECT_EQ(live->device(), "still");
  const std::string told = trouble(*live);
  EXPECT_NE(told.find("still has come to its end"), std::string::npos) << told;
  EXPECT_GT(StillHand::felt_n, 0.1) << "it was felt";
  EXPECT_EQ(live->device(), "mouse");
  EXPECT_EQ(live->take_trouble(), "") << "told once";
}

TEST_F(Live, ALostOneLeavesNoForceBehind) {
  const auto live = this->live();
  live->use({.device = std::make_unique<StillHand>(
                 inside_mm_, [] { throw Error(ErrorCode::Machine, "its cable is out"); })});
  const std::string told = trouble(*live);
  EXPECT_NE(told.find("still is lost"), std::string::npos) << told;
  EXPECT_NE(told.find("its cable is out"), std::string::npos) << told;
  const Felt felt = live->touch().felt();
  EXPECT_EQ(felt.servo.force_n, (std::array<double, 3>{}));
  // Time goes on, and so does the heart.
  const double then_s = felt.servo.time_s;
  EXPECT_GT(then_s, 0.9);
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_GT(live->touch().felt().servo.time_s, then_s);
}

TEST_F(Live, AnotherDeviceEndsTheOneBefore) {
  const auto live = this->live();
  bool ended = false;
  live->use({.device = std::make_unique<StillHand>(inside_mm_, [&ended] { ended = true; })});
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  live->use_mouse();
  EXPECT_EQ(live->device(), "mouse");
  EXPECT_FALSE(ended);
  EXPECT_EQ(live->take_trouble(), "") << "what is wished is no trouble";
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_EQ(live->touch().felt().servo.force_n, (std::array<double, 3>{}));
  EXPECT_GT(live->compute_times().count(), 0U);
  live->stop();
}

}  // namespace
}  // namespace beatlas::viewer
