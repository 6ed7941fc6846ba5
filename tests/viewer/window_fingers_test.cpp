/// Several fingers in the window, and a tool in a cavity.

#include <QCheckBox>
#include <QComboBox>
#include <QLabel>
#include <QSlider>
#include <QTest>
#include <array>
#include <cmath>

#include "runtime/app/touch.h"
#include "tests/viewer/window_fixture.h"

namespace beatlas::viewer {
namespace {

using Window = test::WindowFixture;

app::PlayArguments hand(const char* side, double depth_mm, double radius_mm) {
  app::PlayArguments out;
  out.side = side;
  out.hand = "still";
  out.depth_mm = depth_mm;
  out.tool_radius_mm = radius_mm;
  out.seconds = 3600;
  return out;
}

std::unique_ptr<HeartWindow> window_of(const ViewOptions& options) {
  auto made = std::make_unique<HeartWindow>(options);
  made->show();
  EXPECT_TRUE(QTest::qWaitForWindowExposed(made.get()));
  EXPECT_TRUE(Window::load(*made, "heart.beatlas"));
  return made;
}

ViewOptions thin_tool_in(std::string_view place) {
  ViewOptions options;
  options.view = "anterior";
  options.inside = std::string(place);
  options.tool_radius_mm = 1;
  return options;
}

/// Idle the tool rests in the fluid, and is free there.
void expect_free(HeartWindow& window) {
  ASSERT_NE(window.live(), nullptr) << window.message().toStdString();
  const Touch& touch = window.live()->touch();
  ASSERT_TRUE(QTest::qWaitFor([&] { return touch.felt().servo.ticks > 100; }, 8000));
  EXPECT_EQ(Vec3(touch.felt().servo.force_n.data()).norm(), 0);
  EXPECT_GT(touch.felt().servo.distance_mm, 1);
}

double force_n(const Felt& felt) {
  const auto& [x, y, z] = felt.servo.force_n;
  return Vec3(x, y, z).norm();
}

double apart(double a, double b) { return std::abs(std::remainder(a - b, 1)); }

TEST_F(Window, TwoHandsHoldOneHeartAndAreSeenApart) {
  ViewOptions options;
  options.view = "anterior";
  options.fingers = {hand("left", 4, 2), hand("right", 3, 3)};
  const auto made = window_of(options);
  ASSERT_NE(made->live(), nullptr) << made->message().toStdString();
  Touch& touch = made->live()->touch();
  ASSERT_EQ(touch.fingers(), 2U);
  ASSERT_TRUE(QTest::qWaitFor(
      [&] { return force_n(touch.felt(0)) > 0.1 && force_n(touch.felt(1)) > 0.1; }, 8000))
      << made->message().toStdString();
  EXPECT_EQ(made->live()->finger(1).device(), "simulated");
  // One heart: the second finger's comes to the first one's phase.
  EXPECT_TRUE(QTest::qWaitFor(
      [&] { return apart(touch.felt(0).servo.phase, touch.felt(1).servo.phase) < 0.01; }, 8000));
  HeartDrawing& drawing = *made->picture().drawing();
  const auto drawn_apart = [&] {
    made->step();
    const auto first = drawing.arrow_tip_mm(0);
    const auto second = drawing.arrow_tip_mm(1);
    return first && second && (*first - *second).norm() > 30;
  };
  EXPECT_TRUE(QTest::qWaitFor(drawn_apart, 8000));
  EXPECT_TRUE(QTest::qWaitFor(
      [&] { return Window::find<QLabel>(*made, "told").text().contains("2: "); }, 8000));
  // A phase that is held is held by both.
  Window::find<QSlider>(*made, "phase")
      .setValue(Window::find<QSlider>(*made, "phase").maximum() / 2);
  EXPECT_TRUE(QTest::qWaitFor(
      [&] {
        return apart(touch.felt(0).servo.phase, 0.5) < 1e-3 &&
               apart(touch.felt(1).servo.phase, 0.5) < 1e-3;
      },
      8000));
}

TEST_F(Window, TheMouseIsTheFirstFingerBesideADevice) {
  ViewOptions options;
  options.view = "anterior";
  options.fingers = {hand("left", 4, 2), hand("right", 3, 3)};
  options.fingers[0].device = "mouse";
  const auto made = window_of(options);
  ASSERT_NE(made->live(), nullptr) << made->message().toStdString();
  Touch& touch = made->live()->touch();
  ASSERT_TRUE(QTest::qWaitFor([&] { return force_n(touch.felt(1)) > 0.1; }, 8000));
  EXPECT_EQ(made->live()->device(), "mouse");
  EXPECT_EQ(force_n(touch.felt(0)), 0);
  EXPECT_TRUE(Window::find<QCheckBox>(*made, "touch").isEnabled());
}

TEST_F(Window, AFingerWhoseDeviceIsNotThereIsNamed) {
  ViewOptions options;
  options.view = "anterior";
  options.fingers = {hand("left", 4, 2), hand("right", 3, 3)};
  options.fingers[1].device = "replay";
  options.fingers[1].recording = file("none.csv").toStdString();
  const auto made = window_of(options);
  EXPECT_TRUE(QTest::qWaitFor([&] { return made->message().contains("finger 2"); }, 8000))
      << made->message().toStdString();
  EXPECT_TRUE(made->message().contains("none.csv"));
  EXPECT_EQ(made->live()->device(), "mouse");
}

TEST_F(Window, ATipInACavityFeelsItsWallFromWithin) {
  const auto made = window_of(thin_tool_in("lv_blood"));
  ASSERT_NO_FATAL_FAILURE(expect_free(*made));
  Touch& touch = made->live()->touch();
  for (const Structure structure : {Structure::Heart, Structure::LvBlood}) {
    EXPECT_LT(made->picture().drawing()->look(structure).opacity, 0.5) << "it is seen through";
  }
  made->use_device("simulated", "");
  Felt felt;
  const auto pressed = [&] {
    felt = touch.felt();
    return force_n(felt) > 0.05;
  };
  ASSERT_TRUE(QTest::qWaitFor(pressed, 8000)) << made->message().toStdString();
  // The wall pushes the tip back into the blood.
  const auto& [x, y, z] = felt.servo.position_mm;
  const auto& [fx, fy, fz] = felt.servo.force_n;
  const Vec3 inward = made->picture().drawing()->frame().centre_mm - Vec3(x, y, z);
  EXPECT_GT(Vec3(fx, fy, fz).dot(inward), 0);
}

TEST_F(Window, AThinToolInThePericardiumMeetsTheHeartAndTheSac) {
  ViewOptions options = thin_tool_in(app::kPericardium);
  options.effusion_mm = 8;
  const auto made = window_of(options);
  ASSERT_NO_FATAL_FAILURE(expect_free(*made));
  Touch& touch = made->live()->touch();
  const auto& [x, y, z] = touch.felt().servo.position_mm;
  const Vec3 rest(x, y, z);
  const Vec3 outward = (rest - made->picture().drawing()->frame().centre_mm).normalized();
  for (const double away_mm : {-8.0, 8.0}) {
    made->live()->mouse().put_at(rest);
    ASSERT_TRUE(QTest::qWaitFor([&] { return force_n(touch.felt()) == 0; }, 8000));
    made->live()->mouse().move_to(rest + away_mm * outward);
    double pushed_n = 0;
    ASSERT_TRUE(QTest::qWaitFor(
        [&] {
          const auto& [fx, fy, fz] = touch.felt().servo.force_n;
          pushed_n = Vec3(fx, fy, fz).dot(outward);
          return std::abs(pushed_n) > 0.05;
        },
        8000));
    EXPECT_LT(pushed_n * away_mm, 0) << "back into the fluid";
  }
  EXPECT_TRUE(made->save_png(file("pericardium.png")));
}

// What a file tells of the muscle is an entry of the list of diseases, chosen first.
TEST_F(Window, AMuscleThatAFileTellsIsFeltAndCanBeLeft) {
  ViewOptions options;
  options.view = "anterior";
  options.told.emplace();
  options.told->parameters = palpation::palpation_preset("low_pressure");
  options.told->parameters.muscle.middle.k_v_n_per_m = 111;
  options.told_name = "told.json";
  options.heart_rate_per_min = 90;
  const auto made = window_of(options);
  ASSERT_NE(made->live(), nullptr) << made->message().toStdString();
  Touch& touch = made->live()->touch();
  auto& list = Window::find<QComboBox>(*made, "preset");
  EXPECT_EQ(list.currentText(), "told.json");
  EXPECT_EQ(Window::find<QComboBox>(*made, "model").currentText(), "muscle");
  EXPECT_EQ(touch.constant("muscle/middle/k_v_n_per_m"), 111);
  EXPECT_EQ(touch.settings().heart_rate_per_min, 90);
  list.setCurrentText("healthy");
  EXPECT_NE(touch.constant("muscle/middle/k_v_n_per_m"), 111);
  list.setCurrentText("told.json");
  EXPECT_EQ(touch.constant("muscle/middle/k_v_n_per_m"), 111);
  EXPECT_EQ(made->message(), "");
}

}  // namespace
}  // namespace beatlas::viewer
