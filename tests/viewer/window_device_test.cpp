/// Devices chosen from the window's list: there, absent, lost, at their end.

#include <QCheckBox>
#include <QComboBox>
#include <QLineEdit>
#include <QPushButton>
#include <QTest>
#include <fstream>

#include "tests/viewer/window_fixture.h"

namespace beatlas::viewer {
namespace {

using Window = test::WindowFixture;

void choose(HeartWindow& window, const char* title) {
  Window::find<QComboBox>(window, "device").setCurrentText(title);
}

void tell(HeartWindow& window, const QString& detail) {
  auto& edit = Window::find<QLineEdit>(window, "device_detail");
  edit.clear();
  QTest::keyClicks(&edit, detail);
  QTest::mouseClick(&Window::find<QPushButton>(window, "device_connect"), Qt::LeftButton);
}

bool moved_by(HeartWindow& window, const char* device) {
  return QTest::qWaitFor([&] { return window.live()->device() == device; }, 8000);
}

bool force_is(HeartWindow& window, bool there) {
  return QTest::qWaitFor([&] { return (window.history().last().force_n > 0.1) == there; }, 8000);
}

TEST_F(Window, ASimulatedHandPalpatesAndTheMouseTakesOver) {
  const auto made = window();
  ASSERT_TRUE(load(*made, "heart.beatlas"));
  EXPECT_EQ(made->live()->device(), "mouse");
  choose(*made, "Simulated hand");
  ASSERT_TRUE(moved_by(*made, "simulated")) << made->message().toStdString();
  EXPECT_EQ(made->message(), "");
  EXPECT_FALSE(find<QCheckBox>(*made, "touch").isEnabled());
  EXPECT_TRUE(force_is(*made, true));
  choose(*made, "Mouse");
  ASSERT_TRUE(moved_by(*made, "mouse"));
  EXPECT_TRUE(force_is(*made, false));
  EXPECT_TRUE(find<QCheckBox>(*made, "touch").isEnabled());
}

TEST_F(Window, ARecordingIsPlayedToItsEnd) {
  const auto made = window();
  ASSERT_TRUE(load(*made, "heart.beatlas"));
  const Vec3 centre = made->picture().drawing()->frame().centre_mm;
  {
    std::ofstream csv(file("path.csv").toStdString());
    csv << "t_s,x_mm,y_mm,z_mm\n";
    for (int n = 0; n <= 30; ++n) {  // in and out along x
      const double out_mm = 60 - 25 * std::sin(3.14159265 * n / 30);
      csv << 0.1 * n << ',' << centre.x() + out_mm << ',' << centre.y() << ',' << centre.z()
          << '\n';
    }
  }
  choose(*made, "Recorded path");
  EXPECT_EQ(made->live()->device(), "mouse") << "waits for its file";
  tell(*made, file("missing.csv"));
  EXPECT_TRUE(QTest::qWaitFor([&] { return made->message().contains("missing.csv"); }, 5000));
  EXPECT_EQ(find<QComboBox>(*made, "device").currentText(), "Mouse");
  choose(*made, "Recorded path");
  tell(*made, file("path.csv"));
  ASSERT_TRUE(moved_by(*made, "replay")) << made->message().toStdString();
  EXPECT_TRUE(force_is(*made, true));
  ASSERT_TRUE(moved_by(*made, "mouse"));
  EXPECT_TRUE(QTest::qWaitFor([&] { return made->message().contains("come to its end"); }, 5000));
  EXPECT_TRUE(force_is(*made, false));
  EXPECT_EQ(find<QComboBox>(*made, "device").currentText(), "Mouse");
}

TEST_F(Window, AnAbsentOneIsASentenceAndTheMouseStays) {
  const auto made = window();
  ASSERT_TRUE(load(*made, "heart.beatlas"));
  setenv("FAKE_DHD", "absent", 1);
  const std::vector<std::pair<const char*, QString>> absent{
      {"3D Systems Touch, PHANToM", file("nowhere.so")},
      {"Force Dimension, Falcon", FAKE_DHD},
      {"One-axis lever", file("nowhere")},
      {"Haply Inverse3", "localhost:1"},
      {"Haply Inverse3", "localhost"}};
  for (const auto& [title, detail] : absent) {
    choose(*made, title);
    tell(*made, detail);
    EXPECT_TRUE(QTest::qWaitFor([&] { return made->message().contains("The mouse moves"); }, 8000))
        << title << ": " << made->message().toStdString();
    EXPECT_EQ(made->live()->device(), "mouse") << title;
    EXPECT_EQ(find<QComboBox>(*made, "device").currentText(), "Mouse");
  }
  unsetenv("FAKE_DHD");
}

TEST_F(Window, ALostOneSendsNoForceAndCanBeTakenUpAgain) {
  const auto made = window();
  ASSERT_TRUE(load(*made, "heart.beatlas"));
  setenv("FAKE_DHD", "lost", 1);
  choose(*made, "Force Dimension, Falcon");
  tell(*made, FAKE_DHD);
  EXPECT_TRUE(QTest::qWaitFor([&] { return made->message().contains("lost"); }, 8000))
      << made->message().toStdString();
  EXPECT_EQ(made->live()->device(), "mouse");
  EXPECT_EQ(made->history().last().force_n, 0);
  unsetenv("FAKE_DHD");
  choose(*made, "Force Dimension, Falcon");  // where it is was told before
  ASSERT_TRUE(moved_by(*made, "dhd")) << made->message().toStdString();
  made->close();
}

}  // namespace
}  // namespace beatlas::viewer
