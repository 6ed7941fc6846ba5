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

}  // namespace
}  // namespace beatlas::viewer
