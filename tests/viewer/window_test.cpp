/// The window as a user drives it: real widgets, the real servo's thread, without a display.

#include <QAction>
#include <QCheckBox>
#include <QComboBox>
#include <QLabel>
#include <QMenu>
#include <QMessageBox>
#include <QPushButton>
#include <QSettings>
#include <QShortcut>
#include <QSlider>
#include <QSpinBox>
#include <QTest>
#include <QTimer>
#include <QToolButton>
#include <fstream>

#include "runtime/atlas/structure_colours.h"
#include "tests/viewer/window_fixture.h"

namespace beatlas::viewer {
namespace {

using Window = test::WindowFixture;

TEST_F(Window, OpensAndSaysWhatIsWrong) {
  const auto made = window();
  for (const char* name : {"missing.beatlas", "foreign.beatlas", "broken.beatlas"}) {
    ASSERT_TRUE(load(*made, name));
    EXPECT_TRUE(made->message().contains(name)) << made->message().toStdString();
    EXPECT_EQ(made->picture().drawing(), nullptr);
  }
  ASSERT_TRUE(load(*made, "heart.beatlas")) << made->message().toStdString();
  EXPECT_EQ(made->message(), "");
  // A wrong file leaves what was there.
  const HeartDrawing* before = made->picture().drawing();
  const LiveTouch* touched = made->live();
  ASSERT_TRUE(load(*made, "foreign.beatlas"));
  EXPECT_TRUE(made->message().contains("foreign.beatlas")) << made->message().toStdString();
  EXPECT_EQ(made->live(), touched);
  EXPECT_EQ(made->picture().drawing(), before);
  ASSERT_TRUE(load(*made, "seen.beatlas"));
  EXPECT_EQ(made->live(), nullptr);
  EXPECT_FALSE(find<QCheckBox>(*made, "touch").isEnabled());
  QTest::qWait(100);
}

TEST_F(Window, ReadsBesideTheBeatAndTheNewestWishCounts) {
  const auto made = window();
  ASSERT_TRUE(load(*made, "heart.beatlas"));
  const HeartDrawing* before = made->picture().drawing();
  made->load(file("seen.beatlas"));
  EXPECT_TRUE(made->loading());
  EXPECT_EQ(made->picture().drawing(), before) << "the earlier heart stays";
  EXPECT_TRUE(made->message().contains("seen.beatlas"));
  made->load(file("foreign.beatlas"));
  made->load(file("heart.beatlas"));
  ASSERT_TRUE(QTest::qWaitFor([&] { return !made->loading(); }, 20000));
  EXPECT_EQ(made->message(), "");
  EXPECT_TRUE(made->windowTitle().contains("heart.beatlas"));
  EXPECT_NE(made->live(), nullptr);
  // Closed, and gone, while something is read.
  made->load(file("seen.beatlas"));
  made->close();
  const auto other = window();
  other->load(file("heart.beatlas"));
}

TEST_F(Window, PlaysPausesAndHoldsAPhase) {
  const auto made = window();
  ASSERT_TRUE(load(*made, "heart.beatlas"));
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
  ASSERT_TRUE(load(*made, "heart.beatlas"));
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
  ASSERT_TRUE(load(*made, "heart.beatlas"));
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
  ASSERT_TRUE(load(*made, "heart.beatlas"));
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

TEST_F(Window, MorePressureInTheRightAtriumRaisesTheAortasAndMovesTheLoop) {
  const auto made = window();
  ASSERT_TRUE(load(*made, "heart.beatlas"));
  const auto beat = [&] { return made->live()->touch().felt().circulation.beat; };
  EXPECT_TRUE(
      QTest::qWaitFor([&] { return made->live()->touch().felt().circulation.beats >= 2; }, 8000))
      << "beats";
  const palpation::Beat before = beat();
  auto& rap = find<QSpinBox>(*made, "rap");
  EXPECT_EQ(rap.value(), 7);  // paper B's
  rap.setValue(27);
  // What lies behind the resistance moves what the ventricle ejects against, and so its
  // end-systole.
  EXPECT_TRUE(QTest::qWaitFor(
      [&] {
        return beat().aortic_mean_mmhg > before.aortic_mean_mmhg + 8 &&
               beat().esv_ml > 1.02 * before.esv_ml;
      },
      15000))
      << before.aortic_mean_mmhg << " mmHg, then " << beat().aortic_mean_mmhg << "; "
      << before.esv_ml << " ml, then " << beat().esv_ml << "; " << made->message().toStdString();
  find<QComboBox>(*made, "preset").setCurrentText("low_pressure");
  EXPECT_EQ(rap.value(), 7) << "a preset has its own";
}

TEST_F(Window, AnyConstantIsChangedByItsName) {
  const auto made = window();
  ASSERT_TRUE(load(*made, "heart.beatlas"));
  auto& names = find<QComboBox>(*made, "constant");
  auto& value = find<QDoubleSpinBox>(*made, "constant_value");
  names.setCurrentText("circulation/left_atrial_mmhg");
  EXPECT_EQ(value.value(), 9);
  value.setValue(12);
  EXPECT_EQ(find<QSpinBox>(*made, "lap").value(), 12);
  find<QSpinBox>(*made, "lap").setValue(5);
  EXPECT_EQ(value.value(), 5);
  value.setValue(50);  // beyond 40
  EXPECT_EQ(value.value(), 5);
  EXPECT_NE(made->message().toStdString().find("left_atrial_mmhg"), std::string::npos);
  const auto aortic = [&] {
    return made->live()->touch().felt().circulation.beat.aortic_mean_mmhg;
  };
  EXPECT_TRUE(QTest::qWaitFor([&] { return aortic() > 0; }, 8000)) << "beats";
  names.setCurrentText("circulation/aortic_target_mmhg");
  EXPECT_EQ(value.value(), 0);
  value.setValue(45);
  EXPECT_TRUE(QTest::qWaitFor([&] { return std::abs(aortic() - 45) < 4; }, 20000)) << aortic();
  find<QComboBox>(*made, "preset").setCurrentText("dilated_cardiomyopathy");
  EXPECT_EQ(value.value(), 0) << "a preset has its own";
}

TEST_F(Window, DiseaseIsFeltWhereItLies) {
  pack::PackageContent content = test::sample_content(6, 40, 2, 4);
  atlas::SurfaceMapPayload& map = content.maps.at(0);
  for (std::size_t v = 0; v < map.segment.size(); ++v) {
    map.segment[v] = static_cast<std::uint8_t>(palpation::segment_at(
        static_cast<double>(map.long_axis[v]), static_cast<double>(map.angle_rad[v])));
    for (auto& phase : map.thickness_mm) phase[v] = 12;
  }
  pack::write_package(file("mapped.beatlas").toStdString(), content);
  const auto made = window();
  ASSERT_TRUE(load(*made, "mapped.beatlas")) << made->message().toStdString();
  auto& model = find<QComboBox>(*made, "model");
  EXPECT_TRUE(find<QSpinBox>(*made, "stiffness").isEnabled());
  model.setCurrentText("muscle");
  EXPECT_FALSE(find<QSpinBox>(*made, "stiffness").isEnabled());
  find<QCheckBox>(*made, "touch").setChecked(true);
  HeartWidget& picture = made->picture();
  HeartDrawing& drawing = *picture.drawing();
  const OpenedHeart heart = open_heart(file("mapped.beatlas").toStdString());
  const auto wall = palpation::lv_wall_of(*heart.atlas);
  const auto at = [&](double mm, const Vec3& right) {
    const Vec2 pixel = drawing.pixel_of(drawing.frame().centre_mm + mm * right);
    return QPoint(static_cast<int>(pixel.x()), static_cast<int>(pixel.y()));
  };
  // Seen so that the segment lies at the right border, where the mouse goes straight into it.
  const auto press = [&](int segment) {
    Vec3 right = (wall->mm(wall->middle_of(segment)) - heart.field->centre_mm()).normalized();
    CameraPose pose = drawing.camera();
    pose.up = right.unitOrthogonal();
    pose.towards_viewer = right.cross(pose.up);
    drawing.set_camera(pose);
    QTest::mousePress(&picture, Qt::LeftButton, {}, at(60, right));
    for (double mm = 60; mm >= 34; mm -= 2) {
      QTest::mouseMove(&picture, at(mm, right));
      QTest::qWait(15);
    }
    return right;
  };
  const auto felt_n = [&] {
    QTest::qWait(1200);  // the start ramp, and the muscle's own time
    double sum = 0;
    constexpr int kTimes = 60;
    for (int n = 0; n < kTimes; ++n) {
      QTest::qWait(20);
      sum += made->history().last().force_n;
    }
    return sum / kTimes;
  };
  const auto tells = [&](const char* words) {  // while the wall is where the tool is
    return QTest::qWaitFor([&] { return find<QLabel>(*made, "told").text().contains(words); },
                           5000);
  };
  Vec3 right = press(7);
  const double healthy_n = felt_n();
  EXPECT_TRUE(tells("(mid anterior)"));
  model.setCurrentText("spring");
  find<QComboBox>(*made, "preset").setCurrentText("anterior_infarct");
  EXPECT_EQ(model.currentText(), "muscle") << "a spring knows no disease";
  const double ill_n = felt_n();
  EXPECT_TRUE(tells("(mid anterior, scar"));
  QTest::mouseRelease(&picture, Qt::LeftButton, {}, at(34, right));
  right = press(11);
  const double beside_n = felt_n();
  EXPECT_TRUE(tells("(mid inferolateral)"));
  QTest::mouseRelease(&picture, Qt::LeftButton, {}, at(34, right));
  EXPECT_GT(healthy_n, 0.2);
  EXPECT_GT(palpation::force_jnds(ill_n, healthy_n), 2) << ill_n << " and " << healthy_n;
  EXPECT_GT(palpation::force_jnds(ill_n, beside_n), 2) << ill_n << " and " << beside_n;
}

// Every key that does something is told of.
TEST_F(Window, TheHelpListsTheKeys) {
  const auto made = window();
  QStringList keys;
  for (const QShortcut* one : made->findChildren<QShortcut*>()) keys << one->key().toString();
  QAction* help = nullptr;
  for (QAction* action : made->findChildren<QAction*>()) {
    if (action->shortcut().isEmpty()) continue;
    keys << action->shortcut().toString();
    if (action->shortcut() == QKeySequence("F1")) help = action;
  }
  ASSERT_NE(help, nullptr);
  ASSERT_GE(keys.size(), 20);
  QString text;
  QTimer::singleShot(100, [&] {
    auto* box = qobject_cast<QMessageBox*>(QApplication::activeModalWidget());
    if (box == nullptr) return;
    text = box->text();
    box->close();
  });
  help->trigger();
  for (const QString& key : keys) {
    const bool digit = key.size() == 1 && key[0].isDigit();
    EXPECT_TRUE(text.contains(digit ? "1 to 9" : key)) << key.toStdString();
  }
}

TEST_F(Window, RemembersFilesAndLooksAndHintsOnce) {
  QSettings("beatlas", "beatlas-view").clear();
  {
    const auto made = window();
    ASSERT_TRUE(load(*made, "heart.beatlas"));
    EXPECT_TRUE(made->message().contains("F1")) << made->message().toStdString();
    QTest::mouseClick(&find<QToolButton>(*made, "dismiss"), Qt::LeftButton);
    EXPECT_EQ(made->message(), "");
    ASSERT_TRUE(load(*made, "seen.beatlas"));
    find<QCheckBox>(*made, "show_lv_blood").setChecked(false);
    find<QSlider>(*made, "opacity_heart").setValue(77);
    made->resize(930, 640);
    made->close();
  }
  const auto made = window();
  EXPECT_EQ(made->size(), QSize(930, 640));
  auto& recent = find<QMenu>(*made, "recent");
  Q_EMIT recent.aboutToShow();
  ASSERT_EQ(recent.actions().size(), 2);
  EXPECT_TRUE(recent.actions()[0]->text().contains("seen.beatlas"));
  recent.actions()[1]->trigger();
  ASSERT_TRUE(QTest::qWaitFor([&] { return !made->loading(); }, 20000));
  EXPECT_EQ(made->message(), "") << "hints once";
  EXPECT_TRUE(made->windowTitle().contains("heart.beatlas"));
  EXPECT_FALSE(made->picture().drawing()->look(Structure::LvBlood).visible);
  EXPECT_NEAR(made->picture().drawing()->look(Structure::Heart).opacity, 0.77, 1e-9);
  QTest::mouseClick(&find<QPushButton>(*made, "reset"), Qt::LeftButton);
  EXPECT_TRUE(made->picture().drawing()->look(Structure::LvBlood).visible);
}

TEST_F(Window, PlotsAreSavedAsAPicture) {
  const auto made = window();
  ASSERT_TRUE(load(*made, "heart.beatlas"));
  QTest::qWait(300);
  ASSERT_TRUE(made->save_plots(file("plots.png")));
  const QImage image(file("plots.png"));
  EXPECT_EQ(image.size(), QSize(800, 1200));
  // The atlas's own volume curve, in its colour; the force's, at zero.
  const auto pixels_like = [&](const QColor& colour) {
    int count = 0;
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) {
        const QColor at = image.pixelColor(x, y);
        count += std::abs(at.red() - colour.red()) + std::abs(at.green() - colour.green()) +
                             std::abs(at.blue() - colour.blue()) <
                         30
                     ? 1
                     : 0;
      }
    }
    return count;
  };
  EXPECT_GT(pixels_like(QColor(90, 220, 120)), 100);
  const Colour lv = structure_colour(Structure::LvBlood);
  EXPECT_GT(pixels_like(QColor(lv[0], lv[1], lv[2])), 100);
  EXPECT_FALSE(made->save_plots(file("nowhere/plots.png")));
  EXPECT_TRUE(made->message().contains("plots.png"));
}

TEST_F(Window, AnySizeAndClosingAtOnce) {
  const auto made = window();
  ASSERT_TRUE(load(*made, "heart.beatlas"));
  for (const QSize& size : {QSize(3840, 2160), QSize(800, 600), QSize(200, 150)}) {
    made->resize(size);
    QTest::qWait(50);
    made->step();
    EXPECT_EQ(made->size(), size);
    // What a small window has no room for is left out, not squeezed.
    EXPECT_EQ(find<QWidget>(*made, "plots").isVisible(), size.width() >= 720);
    EXPECT_EQ(find<QSpinBox>(*made, "rate").isVisible(), size.width() >= 480);
  }
  find<QComboBox>(*made, "volume").setCurrentText("muscle");
  made->step();
  made->close();
  const auto other = window();
  EXPECT_TRUE(load(*other, "heart.beatlas"));
  other->close();
}

}  // namespace
}  // namespace beatlas::viewer
