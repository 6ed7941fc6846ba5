/// The LV's wall as colour: what a pixel shows is what the legend says of the map's value there.

#include <QApplication>
#include <QComboBox>
#include <QSlider>
#include <QTest>
#include <algorithm>
#include <cmath>

#include <QVTKOpenGLNativeWidget.h>
#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "runtime/viewer/band_colours.h"
#include "runtime/viewer/display.h"
#include "runtime/viewer/heart_window.h"
#include "runtime/viewer/wall_colours.h"
#include "tests/viewer/ellipsoid.h"

namespace beatlas::viewer {
namespace {

/// CIE L*a*b* of a colour of sRGB, D65.
Vec3 lab_of(const Vec3& linear) {
  Eigen::Matrix3d xyz_from_rgb;
  xyz_from_rgb << 0.4124, 0.3576, 0.1805, 0.2126, 0.7152, 0.0722, 0.0193, 0.1192, 0.9505;
  const Vec3 xyz = (xyz_from_rgb * linear).cwiseQuotient(Vec3(0.9505, 1, 1.089));
  const Vec3 f =
      xyz.unaryExpr([](double t) { return t > 0.008856 ? std::cbrt(t) : 7.787 * t + 16.0 / 116; });
  return {116 * f.y() - 16, 500 * (f.x() - f.y()), 200 * (f.y() - f.z())};
}
Vec3 linear_of(const Rgb& colour) {
  return Vec3(colour[0], colour[1], colour[2]).unaryExpr([](double c) {
    const double s = c / 255;
    return s > 0.04045 ? std::pow((s + 0.055) / 1.055, 2.4) : s / 12.92;
  });
}
/// As an eye without the cones for green sees it (Vienot et al. 1999).
Vec3 seen_without_green(const Vec3& linear) {
  Eigen::Matrix3d lms_from_rgb;
  lms_from_rgb << 17.8824, 43.5161, 4.11935, 3.45565, 27.1554, 3.86714, 0.0299566, 0.184309,
      1.46709;
  Vec3 lms = lms_from_rgb * linear;
  lms.y() = 0.494207 * lms.x() + 1.24827 * lms.z();
  return (lms_from_rgb.inverse() * lms).cwiseMax(0.0).cwiseMin(1.0);
}

/// What walls are coloured by does not hang on where they are drawn.
DrawnSurface at(Structure structure, double beats) {
  return {.structure = structure, .beats = beats, .positions = {}, .normals = {}};
}

TEST(WallColours, StepsOfTheScaleLookEvenAlsoWithoutTellingGreenFromRed) {
  constexpr int kSteps = 16;
  for (const bool blind : {false, true}) {
    std::vector<double> steps;
    double before = -1;
    Vec3 last = Vec3::Zero();
    for (int n = 0; n <= kSteps; ++n) {
      Vec3 linear = linear_of(colour_of_share(double(n) / kSteps));
      if (blind) linear = seen_without_green(linear);
      const Vec3 lab = lab_of(linear);
      EXPECT_GT(lab.x(), before) << n;  // ever brighter
      before = lab.x();
      if (n > 0) steps.push_back((lab - last).norm());
      last = lab;
    }
    const auto [least, most] = std::minmax_element(steps.begin(), steps.end());
    EXPECT_LT(*most / *least, blind ? 4.0 : 3.0);
    EXPECT_GT(*least, 3) << "a step of a sixteenth can be told";
  }
}

TEST(WallColours, NeighbouringSegmentsAreToldApartAlsoWithoutTellingGreenFromRed) {
  const auto apart = [](int one, int other, bool blind) {
    Vec3 a = linear_of(colour_of_segment(one));
    Vec3 b = linear_of(colour_of_segment(other));
    if (blind) {
      a = seen_without_green(a);
      b = seen_without_green(b);
    }
    return (lab_of(a) - lab_of(b)).norm();
  };
  for (int segment = 1; segment <= 16; ++segment) {
    const int ring = segment <= 6 ? 1 : segment <= 12 ? 7 : 13;
    const int count = ring == 13 ? 4 : 6;
    const int beside = ring + (segment - ring + 1) % count;
    const int above = segment <= 6 ? segment + 6 : 17;
    for (const bool blind : {false, true}) {
      EXPECT_GT(apart(segment, beside, blind), 10) << segment << " " << beside << " " << blind;
      if (segment <= 6 || segment >= 13) {
        EXPECT_GT(apart(segment, above, blind), 10) << segment << " " << above << " " << blind;
      }
    }
    for (int other = segment + 1; other <= 17; ++other) {
      EXPECT_GT(apart(segment, other, false), 8) << segment << " " << other;
    }
  }
}

TEST(WallColours, TheBullsEyeIsThatOfTheAha) {
  double area = 0;
  for (int segment = 1; segment <= 17; ++segment) {
    const palpation::BullsEyeSector sector = palpation::bulls_eye_sector(segment);
    area += 0.5 * (sector.end_rad - sector.begin_rad) *
            (sector.outer * sector.outer - sector.inner * sector.inner);
  }
  EXPECT_NEAR(area, std::numbers::pi, 1e-12);  // of the whole disc
  const auto middle = [](int segment) {
    const palpation::BullsEyeSector sector = palpation::bulls_eye_sector(segment);
    const double angle = 0.5 * (sector.begin_rad + sector.end_rad);
    return Vec2(std::cos(angle), std::sin(angle));
  };
  for (const int anterior : {1, 7, 13}) EXPECT_GT(middle(anterior).y(), 0.99);
  for (const int inferior : {4, 10, 15}) EXPECT_LT(middle(inferior).y(), -0.99);
  for (const int septal : {2, 3, 8, 9, 14}) EXPECT_LT(middle(septal).x(), -0.8);
  for (const int lateral : {5, 6, 11, 12, 16}) EXPECT_GT(middle(lateral).x(), 0.8);
}

TEST(WallColours, TheRvHasAThicknessAlone) {
  const auto map_of = [](Structure structure, std::uint8_t segment, float wall_mm) {
    auto map = std::make_shared<atlas::SurfaceMapPayload>();
    map->structure = structure;
    map->long_axis = {0.5F, 0.6F};
    map->angle_rad = {0, 3};
    map->segment = {segment, segment};
    map->thickness_mm = {{wall_mm, 0}};
    return map;
  };
  const std::vector<std::shared_ptr<const atlas::SurfaceMapPayload>> maps{
      map_of(Structure::LvBlood, 7, 9), map_of(Structure::RvBlood, 0, 4)};
  const WallColours thickness(maps, ColourBy::Thickness, {});
  ASSERT_TRUE(thickness.has(Structure::RvBlood));
  EXPECT_EQ(thickness.scale().low, 4);
  std::vector<Rgb> seen;
  thickness.colours_of(at(Structure::RvBlood, 0), seen);
  EXPECT_EQ(seen[0], thickness.scale().colour_of(4));
  EXPECT_EQ(seen[1], kNoWall);
  for (const ColourBy by : {ColourBy::Stiffness, ColourBy::Segments}) {
    const WallColours colours(maps, by, palpation::palpation_preset("healthy"));
    EXPECT_TRUE(colours.has(Structure::LvBlood));
    EXPECT_FALSE(colours.has(Structure::RvBlood));
  }
}

TEST(WallColours, MarksAreRoundNumbersWithinTheScale) {
  EXPECT_EQ(scale_marks({.title = "", .low = 5, .high = 17}, 6),
            (std::vector<double>{6, 8, 10, 12, 14, 16}));
  EXPECT_EQ(scale_marks({.title = "", .low = 0, .high = 1}, 5).size(), 6U);
  EXPECT_EQ(scale_marks({.title = "", .low = 40, .high = 90}, 6).front(), 40);
}

TEST(WallColours, StiffnessIsThatOfTheTableAndTheDisease) {
  auto map = std::make_shared<atlas::SurfaceMapPayload>();
  map->structure = Structure::LvBlood;
  map->long_axis = {0.5F, 0.5F, 0.9F};
  map->angle_rad = {0, 3, 0};
  map->segment = {7, 10, 1};
  map->thickness_mm = {{9, 9, 0}};
  const auto infarct = palpation::palpation_preset("anterior_infarct");
  const WallColours colours({map}, ColourBy::Stiffness, infarct);
  const double ill = 75 * (1 + 0.53 * 0.8) * 0.36;  // Table 1's middle, scarred and thin
  EXPECT_EQ(colours.scale().low, std::floor(ill));
  EXPECT_EQ(colours.scale().high, 75);
  std::vector<Rgb> seen;
  colours.colours_of(at(Structure::LvBlood, 0.3), seen);
  EXPECT_EQ(seen[0], colours.scale().colour_of(ill));
  EXPECT_EQ(seen[1], colour_of_share(1));
  EXPECT_EQ(seen[2], kNoWall);
}

class Colours : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<test::TemporaryFolder>();
    setenv("XDG_CONFIG_HOME", folder_->path().c_str(), 1);  // a user's own state stays
    setenv("QT_QPA_PLATFORM", "xcb", 1);
    display_ = std::make_unique<Display>();
    QSurfaceFormat::setDefaultFormat(QVTKOpenGLNativeWidget::defaultFormat());
    static int count = 1;
    static char name[] = "colours_test";
    static char* names[] = {name, nullptr};
    application_ = std::make_unique<QApplication>(count, names);
    atlas_ = test::ellipsoid_atlas(*folder_, heart_, 8, 5);
  }
  static void TearDownTestSuite() {
    atlas_.reset();
    application_.reset();
    display_.reset();
    folder_.reset();
  }

  static Vec3 pixel(const Picture& picture, const Vec2& at) {
    const auto x = static_cast<std::size_t>(std::lround(at.x()));
    const auto y = static_cast<std::size_t>(std::lround(at.y()));
    const std::uint8_t* rgb = picture.rgb.data() + 3 * (y * std::size_t(picture.width) + x);
    return {double(rgb[0]), double(rgb[1]), double(rgb[2])};
  }

  static inline test::BeatingEllipsoid heart_;
  static inline std::unique_ptr<test::TemporaryFolder> folder_;
  static inline std::unique_ptr<Display> display_;
  static inline std::unique_ptr<QApplication> application_;
  static inline std::shared_ptr<const atlas::Atlas> atlas_;
};

/// Light makes a colour darker, not another one: pixel and legend have the same direction.
TEST_F(Colours, AVertexHasTheLegendsColourOfItsWall) {
  HeartDrawing drawing(atlas_, nullptr, {});
  ASSERT_TRUE(drawing.can_colour_by(ColourBy::Thickness));
  Look hidden = drawing.look(Structure::Heart);
  hidden.visible = false;
  drawing.set_look(Structure::Heart, hidden);
  drawing.set_colouring(ColourBy::Thickness, {});
  ASSERT_NE(drawing.colouring(), nullptr);
  const ColourScale scale = drawing.colouring()->scale();
  EXPECT_EQ(scale.low, 6);
  EXPECT_EQ(scale.high, 11);
  const auto surface = atlas_->surface(Structure::LvBlood);
  const auto map = atlas_->surface_map(Structure::LvBlood);
  for (const std::string_view view : {"anterior", "left", "superior"}) {
    const CameraPose pose = standard_view(drawing.frame(), view);
    drawing.set_camera(pose);
    const Picture picture = drawing.picture(800, 600);
    const LegendPlace legend = drawing.legend_place();
    const std::vector<Vec3f> drawn = drawing.drawn_vertices(Structure::LvBlood);
    int compared = 0;
    for (std::size_t v = 0; v < drawn.size(); v += 7) {
      const Vec3 at = drawn[v].cast<double>();
      const Vec3 normal = (heart_.shape(0).inverse() * (at - heart_.centre_mm)).normalized();
      if (normal.dot(pose.towards_viewer) < 0.6) continue;
      const double share =
          (static_cast<double>(map->thickness_mm[0][v]) - scale.low) / (scale.high - scale.low);
      if (share < 0.02 || share > 0.98) continue;
      const Vec3 told = pixel(picture, {legend.x, legend.y + legend.half_height * (1 - 2 * share)});
      const Vec3 seen = pixel(picture, drawing.pixel_of(at));
      ASSERT_GT(seen.norm(), 30);
      EXPECT_GT(seen.normalized().dot(told.normalized()), 0.998)
          << view << " " << v << ": " << seen.transpose() << " for " << told.transpose();
      ++compared;
    }
    EXPECT_GT(compared, 60) << view;
  }
}

/// What the package tells is half of a band's width within and across slices, which lie along z
/// here.
TEST_F(Colours, AVertexHasTheLegendsColourOfHowWellItIsKnown) {
  const test::TemporaryFolder folder;
  const auto banded = test::ellipsoid_atlas(folder, heart_, 4, 5, 0, true);
  HeartDrawing drawing(banded, nullptr, {});
  ASSERT_TRUE(drawing.can_colour_by(ColourBy::Uncertainty));
  drawing.set_colouring(ColourBy::Uncertainty, {});
  const ColourScale scale = drawing.colouring()->scale();
  EXPECT_EQ(scale.low, 1);
  EXPECT_EQ(scale.high, 6) << "the widest is sqrt(1 + 25)";
  Look opaque = drawing.look(Structure::Heart);
  opaque.opacity = coloured_opacity(ColourBy::Uncertainty, Structure::Heart);
  drawing.set_look(Structure::Heart, opaque);
  EXPECT_TRUE(drawing.colouring()->has(Structure::Heart));
  EXPECT_FALSE(drawing.colouring()->has(Structure::LvBlood)) << "of which nothing is told";
  const CameraPose pose = standard_view(drawing.frame(), "anterior");
  drawing.set_camera(pose);
  const Picture picture = drawing.picture(800, 600);
  const LegendPlace legend = drawing.legend_place();
  const std::vector<Vec3f> drawn = drawing.drawn_vertices(Structure::Heart);
  int compared = 0;
  double least = 1;
  double most = 0;
  for (std::size_t v = 0; v < drawn.size(); v += 7) {
    const Vec3 at = drawn[v].cast<double>();
    const Vec3 normal = (heart_.shape(0).inverse() * (at - heart_.centre_mm)).normalized();
    if (normal.dot(pose.towards_viewer) < 0.6) continue;
    const double known_mm = std::hypot(normal.x(), normal.y()) + 5 * std::abs(normal.z());
    const double share = (known_mm - scale.low) / (scale.high - scale.low);
    if (share < 0.02 || share > 0.98) continue;
    least = std::min(least, share);
    most = std::max(most, share);
    const Vec3 told = pixel(picture, {legend.x, legend.y + legend.half_height * (1 - 2 * share)});
    const Vec3 seen = pixel(picture, drawing.pixel_of(at));
    ASSERT_GT(seen.norm(), 30);
    EXPECT_GT(seen.normalized().dot(told.normalized()), 0.998)
        << v << ": " << seen.transpose() << " for " << told.transpose();
    ++compared;
  }
  EXPECT_GT(compared, 60);
  EXPECT_GT(most - least, 0.5) << "colours that hardly differ show nothing";

  HeartDrawing untold(atlas_, nullptr, {});
  EXPECT_FALSE(untold.can_colour_by(ColourBy::Uncertainty));
  EXPECT_THROW(untold.set_colouring(ColourBy::Uncertainty, {}), Error);
  EXPECT_EQ(untold.colouring(), nullptr);
}

TEST_F(Colours, TheLegendIsTheScaleAndTheBullsEyeTheSegments) {
  HeartDrawing drawing(atlas_, nullptr, {});
  drawing.set_colouring(ColourBy::Thickness, {});
  Picture picture = drawing.picture(800, 600);
  LegendPlace legend = drawing.legend_place();
  for (const double share : {0.1, 0.35, 0.5, 0.77, 0.95}) {
    const Rgb want = colour_of_share(share);
    const Vec3 found = pixel(picture, {legend.x, legend.y + legend.half_height * (1 - 2 * share)});
    EXPECT_LT((found - Vec3(want[0], want[1], want[2])).cwiseAbs().maxCoeff(), 5) << share;
  }
  drawing.set_colouring(ColourBy::Segments, {});
  picture = drawing.picture(800, 600);
  legend = drawing.legend_place();
  for (int segment = 1; segment <= 16; ++segment) {
    const palpation::BullsEyeSector sector = palpation::bulls_eye_sector(segment);
    // Beside the number in the sector's middle.
    const double angle = sector.begin_rad + 0.2 * (sector.end_rad - sector.begin_rad);
    const double r = legend.half_height * 0.5 * (sector.inner + sector.outer);
    const Vec3 found =
        pixel(picture, {legend.x + r * std::cos(angle), legend.y - r * std::sin(angle)});
    const Rgb want = colour_of_segment(segment);
    EXPECT_LT((found - Vec3(want[0], want[1], want[2])).cwiseAbs().maxCoeff(), 5) << segment;
  }
  drawing.set_colouring(ColourBy::Structure, {});
  EXPECT_EQ(drawing.colouring(), nullptr);
}

TEST_F(Colours, AreChosenInTheWindow) {
  ViewOptions options;
  options.view = "anterior";
  HeartWindow window(options);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window));
  OpenedHeart opened;
  opened.atlas = atlas_;
  window.show_heart(loaded_heart(opened, "ellipsoid.beatlas", {}));
  auto* colour = window.findChild<QComboBox*>("colour");
  ASSERT_NE(colour, nullptr);
  ASSERT_TRUE(colour->isEnabled());
  const auto may_choose = [&](int n) {
    return (colour->model()->index(n, 0).flags() & Qt::ItemIsEnabled) != 0;
  };
  EXPECT_TRUE(may_choose(1));
  EXPECT_FALSE(may_choose(4)) << "the package does not tell how well surfaces are known";
  const QString said = window.message();  // a hint, where it is the user's first run
  colour->setCurrentIndex(1);
  const HeartDrawing& drawing = *window.picture().drawing();
  ASSERT_NE(drawing.colouring(), nullptr);
  EXPECT_EQ(drawing.colouring()->by(), ColourBy::Thickness);
  EXPECT_EQ(drawing.look(Structure::Heart).opacity, 0);
  EXPECT_EQ(drawing.look(Structure::LvBlood).opacity, 1);
  window.step();
  colour->setCurrentIndex(2);
  const double healthy = drawing.colouring()->scale().low;
  window.findChild<QComboBox*>("preset")->setCurrentText("anterior_infarct");
  EXPECT_LT(drawing.colouring()->scale().low, healthy - 10);
  colour->setCurrentIndex(0);
  EXPECT_EQ(drawing.colouring(), nullptr);
  EXPECT_NEAR(drawing.look(Structure::Heart).opacity, default_look(Structure::Heart).opacity, 0.01);
  EXPECT_EQ(window.message(), said);
}

}  // namespace
}  // namespace beatlas::viewer
