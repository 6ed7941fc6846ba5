/// What the command line says of a window's start is what the window shows, and Reset goes back to.

#include <QCheckBox>
#include <QComboBox>
#include <QDoubleSpinBox>
#include <QPushButton>
#include <QSettings>
#include <QSlider>
#include <QSpinBox>
#include <QTest>

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

}  // namespace
}  // namespace beatlas::viewer
