/// The window as a user drives it: real widgets, the real servo's thread, without a display.

#include <QApplication>
#include <QCheckBox>
#include <QComboBox>
#include <QPushButton>
#include <QSlider>
#include <QSpinBox>
#include <QTest>
#include <fstream>

#include <gtest/gtest.h>

#include "runtime/viewer/display.h"
#include "runtime/viewer/heart_window.h"
#include "tests/package/sample_package.h"

namespace beatlas::viewer {
namespace {

class Window : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<test::TemporaryFolder>();
    setenv("XDG_CONFIG_HOME", folder_->path().c_str(), 1);  // a user's own state stays
    setenv("QT_QPA_PLATFORM", "xcb", 1);
    display_ = std::make_unique<Display>();
    QSurfaceFormat::setDefaultFormat(QVTKOpenGLNativeWidget::defaultFormat());
    static int count = 1;
    static char name[] = "window_test";
    static char* names[] = {name, nullptr};
    application_ = std::make_unique<QApplication>(count, names);
    pack::write_package(folder_->path() / "heart.beatlas", test::sample_content(10, 45, 2, 4));
    pack::PackageContent seen = test::sample_content(6, 30, 2, 3);
    seen.fields.clear();
    pack::write_package(folder_->path() / "seen.beatlas", seen);
    std::ofstream(folder_->path() / "foreign.beatlas") << "nothing of the kind";
  }
  static void TearDownTestSuite() {
    application_.reset();
    display_.reset();
    folder_.reset();
  }
  static QString file(const char* name) {
    return QString::fromStdString((folder_->path() / name).string());
  }
  static std::unique_ptr<HeartWindow> window() {
    ViewOptions options;
    options.view = "anterior";
    auto made = std::make_unique<HeartWindow>(options);
    made->show();
    EXPECT_TRUE(QTest::qWaitForWindowExposed(made.get()));
    return made;
  }
  template <class Widget>
  static Widget& find(HeartWindow& window, const char* name) {
    auto* found = window.findChild<Widget*>(name);
    if (found == nullptr) throw std::runtime_error(std::string("no widget ") + name);
    return *found;
  }

  static inline std::unique_ptr<test::TemporaryFolder> folder_;
  static inline std::unique_ptr<Display> display_;
  static inline std::unique_ptr<QApplication> application_;
};

TEST_F(Window, OpensAndSaysWhatIsWrong) {
  const auto made = window();
  for (const char* name : {"missing.beatlas", "foreign.beatlas"}) {
    EXPECT_FALSE(made->open(file(name)));
    EXPECT_TRUE(made->message().contains(name)) << made->message().toStdString();
    EXPECT_EQ(made->picture().drawing(), nullptr);
  }
  ASSERT_TRUE(made->open(file("heart.beatlas"))) << made->message().toStdString();
  EXPECT_EQ(made->message(), "");
  // A wrong file leaves what was there.
  const HeartDrawing* before = made->picture().drawing();
  EXPECT_FALSE(made->open(file("foreign.beatlas")));
  EXPECT_EQ(made->picture().drawing(), before);
  ASSERT_TRUE(made->open(file("seen.beatlas")));
  EXPECT_EQ(made->live(), nullptr);
  EXPECT_FALSE(find<QCheckBox>(*made, "touch").isEnabled());
  QTest::qWait(100);
}

TEST_F(Window, PlaysPausesAndHoldsAPhase) {
  const auto made = window();
  ASSERT_TRUE(made->open(file("heart.beatlas")));
  const auto phase = [&] { return made->live()->touch().felt().servo.phase; };
  const double first = phase();
  QTest::qWait(250);
  EXPECT_NE(phase(), first);
  QTest::mouseClick(&find<QPushButton>(*made, "play"), Qt::LeftButton);
  EXPECT_TRUE(
      QTest::qWaitFor([&] { return made->live()->touch().felt().servo.rate_hz < 0.01; }, 6000))
      << "pauses";
  auto& slider = find<QSlider>(*made, "phase");
  slider.setValue(650);
  EXPECT_TRUE(QTest::qWaitFor([&] { return std::abs(phase() - 0.65) < 0.01; }, 8000)) << "holds";
}

TEST_F(Window, CutsAndTurns) {
  const auto made = window();
  ASSERT_TRUE(made->open(file("heart.beatlas")));
  find<QPushButton>(*made, "play").setChecked(false);
  QTest::qWait(100);
  HeartWidget& picture = made->picture();
  const QImage whole = picture.grabFramebuffer();
  find<QComboBox>(*made, "cut").setCurrentText("coronal");
  EXPECT_TRUE(picture.drawing()->cut().has_value());
  made->step();
  EXPECT_NE(picture.grabFramebuffer(), whole);
  const Vec3 towards = picture.drawing()->camera().towards_viewer;
  const QPoint middle = picture.rect().center();
  QTest::mousePress(&picture, Qt::LeftButton, {}, middle);
  QTest::mouseMove(&picture, middle + QPoint(60, 10));
  QTest::mouseRelease(&picture, Qt::LeftButton, {}, middle + QPoint(60, 10));
  EXPECT_GT((picture.drawing()->camera().towards_viewer - towards).norm(), 0.1);
  find<QComboBox>(*made, "cut").setCurrentText("free");
  EXPECT_LT((picture.drawing()->cut()->normal - picture.drawing()->camera().towards_viewer).norm(),
            1e-6);
  find<QComboBox>(*made, "volume").setCurrentText("blood");
  made->step();
  find<QCheckBox>(*made, "show_heart").setChecked(false);
  EXPECT_FALSE(picture.drawing()->look(Structure::Heart).visible);
}

TEST_F(Window, TheMousePressesTheHeartAndTheForceRises) {
  const auto made = window();
  ASSERT_TRUE(made->open(file("heart.beatlas")));
  find<QCheckBox>(*made, "touch").setChecked(true);
  QTest::qWait(700);  // the safety stage's start ramp
  HeartWidget& picture = made->picture();
  HeartDrawing& drawing = *picture.drawing();
  EXPECT_EQ(made->history().last().force_n, 0);
  const CameraPose pose = drawing.camera();
  const Vec3 right = pose.up.cross(pose.towards_viewer);
  const auto at = [&](double mm) {
    const Vec2 pixel = drawing.pixel_of(drawing.frame().centre_mm + mm * right);
    return QPoint(static_cast<int>(pixel.x()), static_cast<int>(pixel.y()));
  };
  QTest::mousePress(&picture, Qt::LeftButton, {}, at(70));
  for (double mm = 70; mm >= 36; mm -= 2) {
    QTest::mouseMove(&picture, at(mm));
    QTest::qWait(20);
  }
  double most_n = 0;
  bool dented = false;
  for (int n = 0; n < 50; ++n) {
    QTest::qWait(30);
    most_n = std::max(most_n, made->history().last().force_n);
    const Touch& touch = made->live()->touch();
    dented = dented || touch.tool_picture(touch.felt()).dent_mm > 1;
  }
  EXPECT_GT(most_n, 0.3);
  EXPECT_TRUE(dented);
  EXPECT_TRUE(made->save_png(file("pressed.png")));
  EXPECT_TRUE(made->save_csv(file("felt.csv")));
  QTest::mouseRelease(&picture, Qt::LeftButton, {}, at(36));
  find<QCheckBox>(*made, "touch").setChecked(false);
  EXPECT_TRUE(QTest::qWaitFor([&] { return made->history().last().force_n == 0; }, 5000))
      << "lets go";

  std::ifstream csv(file("felt.csv").toStdString());
  std::string line;
  std::getline(csv, line);
  EXPECT_EQ(line, "t_s,force_n,depth_mm,volume_ml,lv_mmhg");
  std::size_t rows = 0;
  while (std::getline(csv, line)) ++rows;
  EXPECT_GT(rows, 10U);
  EXPECT_FALSE(QImage(file("pressed.png")).isNull());
  EXPECT_FALSE(made->save_csv(file("nowhere/felt.csv")));
  EXPECT_FALSE(made->message().isEmpty());
}

TEST_F(Window, MorePressureInTheLeftAtriumFillsTheVentricle) {
  const auto made = window();
  ASSERT_TRUE(made->open(file("heart.beatlas")));
  const auto filled_ml = [&] { return made->live()->touch().felt().circulation.beat.edv_ml; };
  EXPECT_TRUE(
      QTest::qWaitFor([&] { return made->live()->touch().felt().circulation.beats >= 2; }, 8000))
      << "beats";
  const double before = filled_ml();
  auto& lap = find<QSpinBox>(*made, "lap");
  lap.setValue(lap.value() + 8);
  EXPECT_TRUE(QTest::qWaitFor([&] { return filled_ml() > 1.03 * before; }, 15000))
      << before << " ml, then " << filled_ml() << "; " << made->message().toStdString();
}

TEST_F(Window, AnySizeAndClosingAtOnce) {
  const auto made = window();
  ASSERT_TRUE(made->open(file("heart.beatlas")));
  find<QComboBox>(*made, "volume").setCurrentText("muscle");
  for (const QSize& size : {QSize(200, 150), QSize(3840, 2160), QSize(800, 600)}) {
    made->resize(size);
    QTest::qWait(50);
    made->step();
  }
  made->close();
  const auto other = window();
  EXPECT_TRUE(other->open(file("heart.beatlas")));
  other->close();
}

}  // namespace
}  // namespace beatlas::viewer
