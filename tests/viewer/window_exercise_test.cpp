/// An exercise in the window, played with the mouse.

#include <QLabel>
#include <QPushButton>
#include <QTest>
#include <fstream>
#include <sstream>

#include "runtime/field/surface_point.h"
#include "tests/json_file.h"
#include "tests/viewer/window_fixture.h"

namespace beatlas::viewer {
namespace {

using Window = test::WindowFixture;

app::PlayArguments exercise_of(const char* session, double seconds) {
  app::PlayArguments out;
  out.package = Window::file("heart.beatlas").toStdString();
  out.exercise = Window::file("exercise.json").toStdString();
  out.session = Window::file(session).toStdString();
  out.device = "mouse";
  out.seed = 3;
  std::ofstream(out.exercise) << R"({"version": 1, "title": "Find it", "task": "find",
    "kinds": ["soft", "scar"], "tool_radius_mm": 3, "seconds": )"
                              << seconds << "}";
  return out;
}

std::unique_ptr<HeartWindow> window_of(const app::PlayArguments& exercise) {
  ViewOptions options;
  options.view = "anterior";
  options.exercise = exercise;
  auto made = std::make_unique<HeartWindow>(options);
  made->show();
  EXPECT_TRUE(QTest::qWaitForWindowExposed(made.get()));
  EXPECT_TRUE(Window::load(*made, "heart.beatlas"));
  return made;
}

QString told(HeartWindow& window) { return Window::find<QLabel>(window, "exercise_told").text(); }

/// On the heart's surface, a little inside of it.
Vec3 pressed_mm() {
  const OpenedHeart heart = open_heart(Window::file("heart.beatlas").toStdString());
  const Vec3 outward = heart.atlas->manifest().workspace_from_lps.linear() * Vec3::UnitX();
  return field::surface_point_mm(*heart.field, outward, 0) - 2 * outward.normalized();
}

TEST_F(Window, AnExerciseIsPlayedMarkedScoredAndComesOutTheSame) {
  const app::PlayArguments exercise = exercise_of("played", 60);
  const auto made = window_of(exercise);
  ASSERT_NE(made->exercise(), nullptr) << made->message().toStdString();
  EXPECT_EQ(made->live(), nullptr);
  auto& mark = Window::find<QPushButton>(*made, "mark_scar");
  ASSERT_TRUE(QTest::qWaitFor([&] { return made->exercise()->seen().playing; }, 20000))
      << told(*made).toStdString();
  EXPECT_FALSE(mark.isEnabled()) << "nothing is touched";
  made->exercise()->mouse().put_at(pressed_mm());
  ASSERT_TRUE(QTest::qWaitFor([&] { return mark.isEnabled(); }, 8000)) << told(*made).toStdString();
  EXPECT_TRUE(told(*made).contains("Trial 1 of 1: mark 1 of 1")) << told(*made).toStdString();
  EXPECT_GT(made->history().last().depth_mm, 0);
  QTest::mouseClick(&mark, Qt::LeftButton);
  ASSERT_TRUE(QTest::qWaitFor([&] { return told(*made).contains("points"); }, 20000))
      << told(*made).toStdString();
  EXPECT_TRUE(Window::find<QPushButton>(*made, "exercise_report").isVisible());
  EXPECT_TRUE(std::filesystem::exists(exercise.session + "/report.html"));
  std::ostringstream out;
  EXPECT_NO_THROW(app::replay_exercise(exercise.package, exercise.session, out));
  EXPECT_NE(out.str().find("came out the same to the bit"), std::string::npos) << out.str();
  const nlohmann::json json = beatlas::test::json_file(exercise.session + "/score.json");
  EXPECT_NE(json_text(json).find("scar"), std::string::npos)
      << "what was marked is what was clicked";
}

TEST_F(Window, AnExerciseThatIsBrokenOffGoesOn) {
  const app::PlayArguments exercise = exercise_of("broken", 30);
  {
    const auto made = window_of(exercise);
    ASSERT_NE(made->exercise(), nullptr);
    ASSERT_TRUE(QTest::qWaitFor([&] { return made->exercise()->seen().servo.time_s > 1; }, 20000));
    made->close();
  }
  EXPECT_TRUE(std::filesystem::exists(exercise.session + "/trial_001_1.csv"));
  EXPECT_FALSE(std::filesystem::exists(exercise.session + "/score.json"));
  const auto again = window_of(exercise);
  ASSERT_TRUE(QTest::qWaitFor([&] { return again->exercise()->seen().playing; }, 20000))
      << told(*again).toStdString();
  EXPECT_LT(again->exercise()->seen().seconds, 29.5);
  // Another heart is not taken in the middle of it.
  again->load(file("seen.beatlas"));
  EXPECT_TRUE(again->message().contains("An exercise is played"));
}

TEST_F(Window, AnExerciseThatCannotBeginSaysWhy) {
  app::PlayArguments exercise = exercise_of("elsewhere", 30);
  exercise.package = file("seen.beatlas").toStdString();  // without a field
  const auto made = window_of(exercise);
  EXPECT_TRUE(QTest::qWaitFor([&] { return told(*made).contains("seen.beatlas"); }, 20000))
      << told(*made).toStdString();
  EXPECT_FALSE(Window::find<QPushButton>(*made, "mark_soft").isEnabled());
}

}  // namespace
}  // namespace beatlas::viewer
