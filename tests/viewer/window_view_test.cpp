/// What the mouse does to view and tool in the window, and what it leaves alone.

#include <QCheckBox>
#include <QComboBox>
#include <QFontInfo>
#include <QPushButton>
#include <QScrollArea>
#include <QScrollBar>
#include <QSlider>
#include <QSpinBox>
#include <QTest>
#include <QWheelEvent>
#include <algorithm>
#include <vector>

#include "tests/viewer/window_fixture.h"

namespace beatlas::viewer {
namespace {

using Window = test::WindowFixture;

TEST_F(Window, ACutLeavesTheView) {
  const auto made = window();
  ASSERT_TRUE(load(*made, "heart.beatlas"));
  HeartDrawing& drawing = *made->picture().drawing();
  find<QComboBox>(*made, "view").setCurrentText("left");
  made->step();
  const auto stays = [&](const CameraPose& before, const std::string& what) {
    made->step();
    const CameraPose now = drawing.camera();
    EXPECT_LT((now.towards_viewer - before.towards_viewer).norm(), 1e-9) << what;
    EXPECT_LT((now.up - before.up).norm(), 1e-9) << what;
    EXPECT_LT((now.focus_mm - before.focus_mm).norm(), 1e-9) << what;
    EXPECT_NEAR(now.height_mm, before.height_mm, 1e-9) << what;
  };
  auto& cut = find<QComboBox>(*made, "cut");
  auto& offset = find<QSlider>(*made, "cut_offset");
  for (int n = cut.count() - 1; n >= 0; --n) {
    const CameraPose before = drawing.camera();
    cut.setCurrentIndex(n);
    offset.setValue(offset.value() == 0 ? 14 : 0);
    stays(before, cut.currentText().toStdString());
  }
  // By the keys, and by letters that a list of words takes for a choice.
  for (QWidget* focus : std::initializer_list<QWidget*>{&made->picture(), &cut}) {
    focus->setFocus();
    for (const Qt::Key key : {Qt::Key_X, Qt::Key_BracketLeft, Qt::Key_BracketRight}) {
      const CameraPose before = drawing.camera();
      QTest::keyClick(focus, key);
      stays(before, "key");
    }
  }
}

TEST_F(Window, TheWheelOverTheControlsScrollsThemAndChangesNothing) {
  const auto made = window();
  ASSERT_TRUE(load(*made, "heart.beatlas"));
  made->resize(1180, 400);  // lower than its controls
  QTest::qWait(50);
  auto* panel = made->findChild<QScrollArea*>();
  ASSERT_NE(panel, nullptr);
  QScrollBar& bar = *panel->verticalScrollBar();
  ASSERT_GT(bar.maximum(), 0);
  find<QPushButton>(*made, "play").setChecked(false);  // the phase's slider stands still
  EXPECT_TRUE(
      QTest::qWaitFor([&] { return made->live()->touch().felt().servo.rate_hz < 0.01; }, 6000));
  made->step();
  const CameraPose view = made->picture().drawing()->camera();
  const auto values = [&] {
    std::vector<int> all;
    for (const auto* one : panel->findChildren<QComboBox*>()) all.push_back(one->currentIndex());
    for (const auto* one : panel->findChildren<QSpinBox*>()) all.push_back(one->value());
    for (const auto* one : panel->findChildren<QSlider*>()) all.push_back(one->value());
    return all;
  };
  const std::vector<int> before = values();
  ASSERT_GE(before.size(), 20U);
  int turned = 0;
  for (QWidget* one : panel->widget()->findChildren<QWidget*>()) {
    if (one->objectName().isEmpty() || one->objectName().startsWith("qt_")) continue;
    if (!one->isVisible() || !one->isEnabled()) continue;
    for (const bool focused : {false, true}) {
      if (focused) one->setFocus();
      for (const int notches : {-1, 1}) {
        bar.setValue(bar.maximum() / 2);
        const QPointF middle = one->rect().center();
        QWheelEvent event(middle, one->mapToGlobal(middle.toPoint()), {}, {0, 120 * notches},
                          Qt::NoButton, Qt::NoModifier, Qt::NoScrollPhase, false);
        // As from the mouse itself: Qt hands on no other wheel's events to what lies around.
        QSpontaneKeyEvent::setSpontaneous(&event);
        qApp->notify(one, &event);
        EXPECT_EQ(values(), before) << one->objectName().toStdString();
        EXPECT_EQ(bar.value() < bar.maximum() / 2, notches > 0) << one->objectName().toStdString();
        ++turned;
      }
    }
  }
  EXPECT_GT(turned, 60);
  EXPECT_LT((made->picture().drawing()->camera().towards_viewer - view.towards_viewer).norm(),
            1e-9);
}

// The idle tool waits behind the heart, so that it may not come to its front in a straight line.
TEST_F(Window, AFirstContactBeginsAtTheSurface) {
  const auto made = window();
  ASSERT_TRUE(load(*made, "heart.beatlas"));
  find<QPushButton>(*made, "play").setChecked(false);
  EXPECT_TRUE(
      QTest::qWaitFor([&] { return made->live()->touch().felt().servo.rate_hz < 0.01; }, 6000));
  auto& touch = find<QCheckBox>(*made, "touch");
  touch.setChecked(true);
  QTest::qWait(700);  // the safety stage's start ramp
  HeartWidget& picture = made->picture();
  HeartDrawing& drawing = *picture.drawing();
  // Of every fifth tick, however long pictures take.
  const auto deepest = [&](int waited_ms, double& force_n) {
    const double begin_s = made->history().last().time_s;
    QTest::qWait(waited_ms);
    made->step();
    const auto most = [&](const Panel& panel) {
      const Curve& line = panel.curves.front();
      double highest = 0;
      for (std::size_t n = 0; n < line.x.size(); ++n) {
        if (line.x[n] > begin_s) highest = std::max(highest, line.y[n]);
      }
      return highest;
    };
    const std::vector<Panel> panels = made->history().panels();
    force_n = std::max(force_n, most(panels.at(0)));
    return most(panels.at(1));
  };
  for (const char* view : {"anterior", "posterior", "right"}) {
    find<QComboBox>(*made, "view").setCurrentText(view);
    made->step();
    const Vec2 pixel = drawing.pixel_of(drawing.frame().centre_mm);
    const QPoint at(static_cast<int>(pixel.x()), static_cast<int>(pixel.y()));
    double force_n = 0;
    QTest::mousePress(&picture, Qt::LeftButton, {}, at);
    EXPECT_LT(deepest(900, force_n), 1) << view << ", pressed";
    EXPECT_LT(force_n, 0.2) << view << ", pressed";
    const Felt felt = made->live()->touch().felt();
    EXPECT_LT(felt.servo.distance_mm, 1) << view << ": it is at the surface";
    // From here the wheel pushes it in, step by step.
    for (int notch = 1; notch <= 4; ++notch) {
      const double before_mm = press_row(made->live()->touch().felt()).depth_mm;
      QWheelEvent event(QPointF(at), picture.mapToGlobal(at), {}, {0, 120}, Qt::LeftButton,
                        Qt::NoModifier, Qt::NoScrollPhase, false);
      QApplication::sendEvent(&picture, &event);
      EXPECT_LT(deepest(400, force_n), before_mm + 1.5) << view << notch;
    }
    EXPECT_GT(press_row(made->live()->touch().felt()).depth_mm, 2) << view;
    QTest::mouseRelease(&picture, Qt::LeftButton, {}, at);
    // Nor does it leave through the heart.
    const double held_mm = press_row(made->live()->touch().felt()).depth_mm;
    force_n = 0;
    touch.setChecked(false);
    EXPECT_LT(deepest(500, force_n), held_mm + 0.5) << view << ", lifted";
    EXPECT_EQ(press_row(made->live()->touch().felt()).force_n, 0);
    touch.setChecked(true);
  }
}

TEST_F(Window, WordsGrowByTheWish) {
  ViewOptions options;
  options.view = "anterior";
  const auto usual = std::make_unique<HeartWindow>(options);
  options.text_scale = 1.75;
  const auto large = std::make_unique<HeartWindow>(options);
  for (const char* name : {"rate", "view", "touch", "told"}) {
    const auto height = [&](HeartWindow& made) {
      return QFontInfo(find<QWidget>(made, name).font()).pixelSize();
    };
    EXPECT_NEAR(height(*large), 1.75 * height(*usual), 1.0) << name;
  }
}

}  // namespace
}  // namespace beatlas::viewer
