/// What the command line says of a window's start is what the window shows, and Reset goes back to.

#include <QCheckBox>
#include <QComboBox>
#include <QDoubleSpinBox>
#include <QPushButton>
#include <QSettings>
#include <QSlider>
#include <QSpinBox>
#include <QTest>
#include <cmath>
#include <functional>
#include <vector>

#include "tests/viewer/window_fixture.h"

namespace beatlas::viewer {
namespace {

using Window = test::WindowFixture;

TEST_F(Window, AColouringOfTheStartHidesNothingThatIsAskedFor) {
  ViewOptions options;
  options.colour = ColourBy::Thickness;
  options.opacity = {{Structure::Heart, 0.2}};
  const auto made = window(options);
  ASSERT_TRUE(load(*made, "heart.beatlas"));
  const auto as_asked = [&](const char* when) {
    const HeartDrawing& drawing = *made->picture().drawing();
    ASSERT_NE(drawing.colouring(), nullptr) << when;
    EXPECT_EQ(drawing.colouring()->by(), ColourBy::Thickness) << when;
    EXPECT_TRUE(drawing.look(Structure::LvBlood).visible) << when;
    EXPECT_EQ(drawing.look(Structure::LvBlood).opacity, 1) << when;
    EXPECT_TRUE(drawing.look(Structure::Heart).visible) << when;
    EXPECT_NEAR(drawing.look(Structure::Heart).opacity, 0.2, 1e-9) << when;
    EXPECT_TRUE(find<QCheckBox>(*made, "show_lv_blood").isChecked()) << when;
    EXPECT_EQ(find<QSlider>(*made, "opacity_heart").value(), 20) << when;
  };
  as_asked("at the start");
  find<QCheckBox>(*made, "show_lv_blood").setChecked(false);
  find<QComboBox>(*made, "colour").setCurrentIndex(0);
  QTest::mouseClick(&find<QPushButton>(*made, "reset"), Qt::LeftButton);
  as_asked("after Reset");
}

TEST_F(Window, LooksOfAColouringAreNotTheUsers) {
  const auto kept = [&](const char* after) {
    const auto made = window();
    ASSERT_TRUE(load(*made, "heart.beatlas"));
    const HeartDrawing& drawing = *made->picture().drawing();
    EXPECT_EQ(drawing.colouring(), nullptr) << after;
    EXPECT_NEAR(drawing.look(Structure::Heart).opacity, 0.77, 1e-9) << after;
    EXPECT_FALSE(drawing.look(Structure::LvBlood).visible) << after;
    made->close();
  };
  {
    const auto made = window();
    ASSERT_TRUE(load(*made, "heart.beatlas"));
    find<QSlider>(*made, "opacity_heart").setValue(77);
    find<QCheckBox>(*made, "show_lv_blood").setChecked(false);
    made->close();
  }
  kept("plain");
  {
    ViewOptions options;
    options.colour = ColourBy::Thickness;
    const auto made = window(options);
    ASSERT_TRUE(load(*made, "heart.beatlas"));
    EXPECT_TRUE(made->picture().drawing()->look(Structure::LvBlood).visible)
        << "the wall that is to be seen";
    made->close();
  }
  kept("coloured by the command line");
  {
    const auto made = window();
    ASSERT_TRUE(load(*made, "heart.beatlas"));
    find<QComboBox>(*made, "colour").setCurrentIndex(1);
    made->close();
  }
  kept("coloured in the window");
}

TEST_F(Window, AViewOfTheStartKeepsItsZoom) {
  ViewOptions options;
  options.view = "left";
  options.zoom = 2;
  const auto made = window(options);
  ASSERT_TRUE(load(*made, "heart.beatlas"));
  made->step();
  HeartDrawing& drawing = *made->picture().drawing();
  const double near_mm = drawing.camera().height_mm;
  drawing.fit_camera(standard_view(drawing.frame(), "left"));
  EXPECT_NEAR(drawing.camera().height_mm, 2 * near_mm, 1e-6);
}

TEST_F(Window, ACutOfTheStartIsAsExactAsItWasTold) {
  ViewOptions options;
  options.cut = "four-chamber";
  options.cut_offset_mm = 2.6;
  options.image_on_cut = false;
  const auto made = window(options);
  ASSERT_TRUE(load(*made, "heart.beatlas"));
  HeartDrawing& drawing = *made->picture().drawing();
  auto& image = find<QCheckBox>(*made, "cut_image");
  EXPECT_FALSE(image.isChecked());
  EXPECT_FALSE(drawing.image_on_cut());
  const auto lies_at = [&](const std::string& name, double offset_mm, const char* when) {
    ASSERT_TRUE(drawing.cut().has_value()) << when;
    const CutPlane wanted = standard_cut(drawing.frame(), name, offset_mm);
    EXPECT_LT((drawing.cut()->point_mm - wanted.point_mm).norm(), 1e-9) << when;
    EXPECT_LT((drawing.cut()->normal - wanted.normal).norm(), 1e-9) << when;
  };
  lies_at("four-chamber", 2.6, "at the start");
  image.setChecked(true);
  EXPECT_TRUE(drawing.image_on_cut());
  lies_at("four-chamber", 2.6, "with the image");
  find<QComboBox>(*made, "cut").setCurrentText("axial");
  lies_at("axial", 2.6, "another plane");
  find<QSlider>(*made, "cut_offset").setValue(7);
  lies_at("axial", 7, "moved");
  QTest::mouseClick(&find<QPushButton>(*made, "reset"), Qt::LeftButton);
  lies_at("four-chamber", 2.6, "after Reset");
  EXPECT_FALSE(drawing.image_on_cut());
}

TEST_F(Window, AFreeCutOfTheStartIsMovedAndStays) {
  ViewOptions options;
  const Vec3 normal = Vec3(1, 2, 2) / 3;
  options.free_cut = CutPlane{.point_mm = {3, 4, 5}, .normal = normal};
  const auto made = window(options);
  ASSERT_TRUE(load(*made, "heart.beatlas"));
  const HeartDrawing& drawing = *made->picture().drawing();
  EXPECT_EQ(find<QComboBox>(*made, "cut").currentText(), "free");
  const auto lies_at = [&](const Vec3& point_mm, const char* when) {
    ASSERT_TRUE(drawing.cut().has_value()) << when;
    EXPECT_LT((drawing.cut()->normal - normal).norm(), 1e-9) << when;
    EXPECT_NEAR(normal.dot(drawing.cut()->point_mm - point_mm), 0, 1e-9) << when;
  };
  lies_at({3, 4, 5}, "at the start");
  find<QCheckBox>(*made, "cut_image").setChecked(false);
  lies_at({3, 4, 5}, "without the image");
  find<QSlider>(*made, "cut_offset").setValue(9);
  lies_at({6, 10, 11}, "moved");
}

TEST_F(Window, ResetTakesBackWhatWasSetByHand) {
  const auto made = window();
  ASSERT_TRUE(load(*made, "heart.beatlas"));
  auto& names = find<QComboBox>(*made, "constant");
  auto& value = find<QDoubleSpinBox>(*made, "constant_value");
  const Touch& touch = made->live()->touch();
  const palpation::PalpationParameters before = touch.parameters();
  const double rate_per_min = touch.settings().heart_rate_per_min;
  names.setCurrentText("muscle/middle/k_v_n_per_m");
  const double k_v = value.value();
  value.setValue(300);
  find<QSpinBox>(*made, "lap").setValue(20);
  find<QSpinBox>(*made, "rate").setValue(110);
  find<QSpinBox>(*made, "stiffness").setValue(500);
  QTest::mouseClick(&find<QPushButton>(*made, "reset"), Qt::LeftButton);
  EXPECT_EQ(palpation::palpation_to_json(touch.parameters()), palpation::palpation_to_json(before));
  EXPECT_EQ(touch.settings().heart_rate_per_min, rate_per_min);
  EXPECT_EQ(value.value(), k_v);
  EXPECT_EQ(find<QSpinBox>(*made, "lap").value(), 9);
  EXPECT_EQ(find<QSpinBox>(*made, "rate").value(), std::lround(rate_per_min));
}

TEST_F(Window, ALoopIsOfTheSettingsThatAreThere) {
  const auto made = window();
  ASSERT_TRUE(load(*made, "heart.beatlas"));
  const auto natural = [&] { return made->history().panels().back().curves.front().x.size(); };
  ASSERT_TRUE(QTest::qWaitFor([&] { return natural() > 0; }, 8000));
  const std::vector<std::function<void()>> changes{
      [&] { find<QComboBox>(*made, "preset").setCurrentText("dilated_cardiomyopathy"); },
      [&] { find<QSpinBox>(*made, "lap").setValue(20); },
      [&] { find<QSpinBox>(*made, "rate").setValue(40); }};
  for (const auto& change : changes) {
    change();
    EXPECT_TRUE(QTest::qWaitFor([&] { return natural() == 0; }, 500)) << "of what is over";
    EXPECT_TRUE(QTest::qWaitFor([&] { return natural() > 0; }, 8000)) << "the next whole beat";
  }
}

}  // namespace
}  // namespace beatlas::viewer
