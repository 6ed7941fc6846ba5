/// Pictures against closed form, projected as the camera does.

#include <algorithm>
#include <functional>
#include <numbers>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "runtime/viewer/display.h"
#include "runtime/viewer/drawing.h"
#include "runtime/viewer/stills.h"
#include "runtime/viewer/touch.h"
#include "tests/viewer/ellipsoid.h"

namespace beatlas::viewer {
namespace {

using std::numbers::pi;
using test::BeatingEllipsoid;

constexpr int kWidth = 640;
constexpr int kHeight = 480;
constexpr double kPixels = 1.5;  // what a contour may be off

class Pictures : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    display_ = std::make_unique<Display>();
    folder_ = std::make_unique<test::TemporaryFolder>();
    atlas_ = test::ellipsoid_atlas(*folder_, heart_, 12, 5);
  }
  static void TearDownTestSuite() {
    atlas_.reset();
    folder_.reset();
    display_.reset();
  }

  static std::unique_ptr<HeartDrawing> drawing() {
    auto made = std::make_unique<HeartDrawing>(atlas_, nullptr, DrawingOptions{.caption = false});
    for (const Structure structure : {Structure::Heart, Structure::LvBlood}) {
      Look look = made->look(structure);
      look.opacity = 1;
      look.visible = structure == Structure::Heart;
      made->set_look(structure, look);
    }
    return made;
  }

  static inline BeatingEllipsoid heart_;
  static inline std::unique_ptr<Display> display_;
  static inline std::unique_ptr<test::TemporaryFolder> folder_;
  static inline std::shared_ptr<const atlas::Atlas> atlas_;
};

std::array<int, 3> colour_at(const Picture& picture, int x, int y) {
  const std::size_t at =
      3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) +
           static_cast<std::size_t>(x));
  return {picture.rgb[at], picture.rgb[at + 1], picture.rgb[at + 2]};
}

bool differs(const Picture& a, const Picture& b, int x, int y) {
  const auto ours = colour_at(a, x, y);
  const auto theirs = colour_at(b, x, y);
  int most = 0;
  for (std::size_t n = 0; n < 3; ++n) most = std::max(most, std::abs(ours[n] - theirs[n]));
  return most > 12;
}

// How far from `middle` along the angle (counter-clockwise, y up) the last pixel is that `is` so.
double last_along(const Picture& picture, const Vec2& middle, double angle,
                  const std::function<bool(int, int)>& is) {
  double last = -1;
  for (double r = 0; r < picture.width; r += 0.1) {
    const auto x = static_cast<int>(std::lround(middle.x() + r * std::cos(angle)));
    const auto y = static_cast<int>(std::lround(middle.y() - r * std::sin(angle)));
    if (x < 0 || y < 0 || x >= picture.width || y >= picture.height) break;
    if (is(x, y)) last = r;
  }
  return last;
}

TEST_F(Pictures, SilhouettesAreTheClosedForms) {
  const auto heart = drawing();
  for (const std::string_view view : {"anterior", "left", "four-chamber", "superior"}) {
    const CameraPose pose = standard_view(heart->frame(), view);
    heart->set_camera(pose);
    const Vec3 right = pose.up.cross(pose.towards_viewer);
    Look look = heart->look(Structure::Heart);
    look.visible = false;
    heart->set_look(Structure::Heart, look);
    const Picture empty = heart->picture(kWidth, kHeight);
    look.visible = true;
    heart->set_look(Structure::Heart, look);
    for (const double beats : {0.0, 0.21, 0.5, 0.83}) {
      heart->set_beats(beats);
      const Picture picture = heart->picture(kWidth, kHeight);
      const Vec2 middle = heart->pixel_of(heart_.centre_mm);
      for (int n = 0; n < 48; ++n) {
        const double angle = 2 * pi * n / 48;
        const double found = last_along(
            picture, middle, angle, [&](int x, int y) { return differs(picture, empty, x, y); });
        const double exact =
            heart->pixels_per_mm() * heart_.shadow_along(beats, right, pose.up, angle);
        EXPECT_NEAR(found, exact, kPixels) << view << ' ' << beats << ' ' << angle;
      }
    }
  }
}

TEST_F(Pictures, CutContoursAreTheClosedForms) {
  const auto heart = drawing();
  for (const std::string_view cut : {"axial", "coronal", "sagittal", "four-chamber"}) {
    for (const bool image : {false, true}) {
      const CutPlane plane = standard_cut(heart->frame(), cut, 0);
      CameraPose pose;
      pose.focus_mm = heart_.centre_mm;
      pose.towards_viewer = plane.normal;
      pose.up = plane.normal.unitOrthogonal();
      pose.height_mm = 120;
      heart->set_camera(pose);
      heart->set_image_on_cut(image);
      // Beside the images the surface's inside would be seen, whose light can have the line's
      // colour.
      Look look = heart->look(Structure::Heart);
      look.opacity = image ? 0 : 1;
      heart->set_look(Structure::Heart, look);
      const Vec3 right = pose.up.cross(pose.towards_viewer);
      heart->set_beats(0.37);
      heart->set_cut(CutPlane{.point_mm = heart_.centre_mm, .normal = plane.normal});
      const Picture picture = heart->picture(kWidth, kHeight);
      // The line alone has this colour: the area within it is darker.
      const Vec3 line = 255 * heart->look(Structure::Heart).colour;
      const Vec2 middle = heart->pixel_of(heart_.centre_mm);
      for (int n = 0; n < 36; ++n) {
        const double angle = 2 * pi * n / 36;
        const Vec2 along(std::cos(angle), -std::sin(angle));
        double sum = 0;
        int count = 0;
        // Within a degree and a half: a line of short pieces has gaps of a pixel.
        for (int y = 0; y < kHeight; ++y) {
          for (int x = 0; x < kWidth; ++x) {
            const auto [r, g, b] = colour_at(picture, x, y);
            if (std::abs(r - line.x()) > 14 || std::abs(g - line.y()) > 14 ||
                std::abs(b - line.z()) > 14) {
              continue;
            }
            const Vec2 from_middle = Vec2(x, y) - middle;
            if (along.dot(from_middle) < std::cos(0.025) * from_middle.norm()) continue;
            sum += from_middle.norm();
            ++count;
          }
        }
        ASSERT_GT(count, 0) << cut << ' ' << angle;
        const Vec3 direction = std::cos(angle) * right + std::sin(angle) * pose.up;
        EXPECT_NEAR(sum / count, heart->pixels_per_mm() * heart_.radius_along(0.37, direction),
                    kPixels)
            << cut << ' ' << image << ' ' << angle;
      }
    }
  }
}

// What is cut away is not there, what stays is.
TEST_F(Pictures, ACutTakesTheNormalsSide) {
  const auto heart = drawing();
  CameraPose pose = standard_view(heart->frame(), "anterior");
  heart->set_camera(pose);
  const Vec3 right = pose.up.cross(pose.towards_viewer);
  heart->set_cut(CutPlane{.point_mm = heart_.centre_mm, .normal = right});
  const Picture half = heart->picture(kWidth, kHeight);
  Look look = heart->look(Structure::Heart);
  look.visible = false;
  heart->set_look(Structure::Heart, look);
  heart->set_image_on_cut(false);
  const Picture empty = heart->picture(kWidth, kHeight);
  const Vec2 there = heart->pixel_of(heart_.centre_mm - 15 * right);
  const Vec2 gone = heart->pixel_of(heart_.centre_mm + 15 * right);
  EXPECT_TRUE(differs(half, empty, static_cast<int>(there.x()), static_cast<int>(there.y())));
  EXPECT_FALSE(differs(half, empty, static_cast<int>(gone.x()), static_cast<int>(gone.y())));
}

TEST_F(Pictures, PointsGoToPixelsAndBack) {
  const auto heart = drawing();
  (void)heart->picture(kWidth, kHeight);
  const Vec3 place = heart_.centre_mm + Vec3(11, -7, 23);
  const Vec3 back = heart->point_at(heart->pixel_of(place), heart->depth_of(place));
  EXPECT_LT((back - place).norm(), 1e-6);
}

TEST_F(Pictures, TheSameMomentGivesTheSamePicture) {
  const auto one = drawing();
  const auto other = drawing();
  one->set_beats(0.3);
  (void)one->picture(kWidth, kHeight);
  one->set_beats(0.62);
  other->set_beats(3.62);
  EXPECT_EQ(one->picture(kWidth, kHeight).rgb, other->picture(kWidth, kHeight).rgb);
}

// The muscle's surface lies on the heart's, now before it, now behind: seen from anywhere an opaque
// heart hides it, and one that lets it through does so evenly, by its opacity.
TEST_F(Pictures, WhatTheHeartEnclosesNeverStandsOutOfIt) {
  const auto coinciding = test::ellipsoid_atlas(*folder_, heart_, 4, 5, 0.015);
  HeartDrawing drawing(coinciding, nullptr, DrawingOptions{.caption = false});
  const auto picture = [&](double heart_opacity, bool muscle) {
    Look look = drawing.look(Structure::Heart);
    look.visible = heart_opacity > 0;
    look.opacity = heart_opacity;
    drawing.set_look(Structure::Heart, look);
    look = drawing.look(Structure::LvMyocardium);
    look.visible = muscle;
    drawing.set_look(Structure::LvMyocardium, look);
    return drawing.picture(kWidth, kHeight);
  };
  constexpr double kVeil = 0.4;
  for (const std::string_view view : {"anterior", "left", "apex"}) {
    const CameraPose pose = standard_view(drawing.frame(), view);
    drawing.set_camera(pose);
    const Vec3 right = pose.up.cross(pose.towards_viewer);
    for (const double beats : {0.0, 0.5}) {
      drawing.set_beats(beats);
      const Picture hidden = picture(1, true);
      const Picture heart = picture(1, false);
      const Picture muscle = picture(0, true);
      const Picture veiled = picture(kVeil, true);
      const Vec2 middle = drawing.pixel_of(heart_.centre_mm);
      int inside = 0;
      int through = 0;
      int uneven = 0;
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          const Vec2 from(x - middle.x(), middle.y() - y);
          const double angle = std::atan2(from.y(), from.x());
          // The muscle's own waves stand beyond the heart's outline.
          if (from.norm() >
              0.97 * drawing.pixels_per_mm() * heart_.shadow_along(beats, right, pose.up, angle)) {
            continue;
          }
          ++inside;
          through += differs(hidden, heart, x, y) ? 1 : 0;
          const auto expected = [&](std::size_t n) {
            return kVeil * colour_at(heart, x, y)[n] + (1 - kVeil) * colour_at(muscle, x, y)[n];
          };
          for (std::size_t n = 0; n < 3; ++n) {
            if (std::abs(colour_at(veiled, x, y)[n] - expected(n)) > 4) {
              ++uneven;
              break;
            }
          }
        }
      }
      EXPECT_GT(inside, 10000);
      EXPECT_EQ(through, 0) << view << ' ' << beats;
      EXPECT_EQ(uneven, 0) << view << ' ' << beats;
    }
  }
}

TEST_F(Pictures, VolumesDifferByPresetAndPhase) {
  const auto heart = drawing();
  heart->set_look(Structure::Heart, {.visible = false});
  const Picture empty = heart->picture(200, 150);
  heart->set_volume(VolumePreset::Blood);
  const Picture blood = heart->picture(200, 150);
  heart->set_volume(VolumePreset::Muscle);
  const Picture muscle = heart->picture(200, 150);
  EXPECT_NE(blood.rgb, empty.rgb);
  EXPECT_NE(muscle.rgb, empty.rgb);
  EXPECT_NE(muscle.rgb, blood.rgb);
  heart->set_beats(0.5);
  EXPECT_NE(heart->picture(200, 150).rgb, muscle.rgb);
}

// Which of VTK's casters is quick is known by the renderer of GL: before the first picture, too.
TEST_F(Pictures, AVolumeInTheFirstPictureIsThatOfLaterOnes) {
  const auto first = drawing();
  first->set_volume(VolumePreset::Muscle);
  const auto later = drawing();
  (void)later->picture(200, 150);
  later->set_volume(VolumePreset::Muscle);
  EXPECT_EQ(first->picture(200, 150).rgb, later->picture(200, 150).rgb);
}

// VTK may take the last window's width to height for a new one's: its volumes were squeezed.
TEST_F(Pictures, VolumesOfOneDrawingAfterAnotherAreTheSame) {
  std::vector<std::uint8_t> before;
  for (int round = 0; round < 24; ++round) {
    const auto heart = drawing();
    heart->set_volume(VolumePreset::Muscle);
    const std::vector<std::uint8_t> now = heart->picture(200, 150).rgb;
    EXPECT_TRUE(round == 0 || now == before) << round;
    before = now;
  }
}

// The hardest taxel, the only one that is touched, has the scale's last colour where it stands:
// beside the marker of 110 pixels, 18 pixels off, 110 pixels for 8.
TEST_F(Pictures, TaxelsStandBesideTheMarker) {
  HeartDrawing heart(atlas_, nullptr, {});
  ToolPicture tool;
  tool.touching = true;
  tool.taxels.area_mm2 = 4;
  tool.taxels.peak_kpa = 20;
  tool.taxels.pressure_kpa[1 * haptics::TaxelMap::kSide + 6] = 12;
  heart.set_tool(tool);
  const Picture shown = heart.picture(800, 600);
  const auto colour = [&](const Picture& of, int column, int row) {
    const double pitch = 110.0 / haptics::TaxelMap::kSide;
    const auto x = static_cast<int>(110 + 18 + (column + 0.5) * pitch);
    const auto y = static_cast<int>(600 - (18 + (row + 0.5) * pitch));
    const auto at = static_cast<std::size_t>(3 * (y * 800 + x));
    return Rgb{of.rgb[at], of.rgb[at + 1], of.rgb[at + 2]};
  };
  EXPECT_EQ(colour(shown, 6, 1), colour_of_share(1));
  EXPECT_EQ(colour(shown, 1, 6), colour(shown, 5, 1));
  EXPECT_NE(colour(shown, 1, 6), colour_of_share(1));
  tool.touching = false;
  heart.set_tool(tool);
  EXPECT_NE(colour(heart.picture(800, 600), 6, 1), colour_of_share(1));
}

// A press on an atlas with a field: the line on the cut goes in by as much as the patch says.
TEST_F(Pictures, TheDentIsAsDeepAsThePatchSays) {
  const std::filesystem::path file = folder_->path() / "field.beatlas";
  pack::write_package(file, test::sample_content(10, 45, 2, 5));
  const OpenedHeart opened = open_heart(file);
  Touch touch(opened.atlas->manifest(), opened.field, {});
  const Vec3 direction =
      opened.atlas->manifest().workspace_from_lps.linear() * Vec3(0.9, -0.4, 0.1);
  const double phase = 0.3;
  const PressRun run = run_press(touch, *opened.field, direction, 6, phase);
  const ToolPicture tool = touch.tool_picture(run.last);
  ASSERT_TRUE(tool.touching);
  EXPECT_NEAR(tool.dent_mm, 6, 0.5);  // the sphere's distance and the way along the normal differ
  EXPECT_NEAR(tool.dent_mm, run.rows.back().depth_mm, 1e-9);
  EXPECT_GT(tool.force_n.norm(), 0.5);

  HeartDrawing heart(opened.atlas, opened.field, {.caption = false});
  for (const Structure structure : kAllStructures) {
    Look look = heart.look(structure);
    look.opacity = 1;
    look.visible = structure == Structure::Heart;
    heart.set_look(structure, look);
  }
  heart.set_image_on_cut(false);
  CameraPose pose;
  pose.focus_mm = tool.dent_place_mm - 10 * tool.dent_normal;
  pose.up = tool.dent_normal;
  pose.towards_viewer = tool.dent_normal.unitOrthogonal();
  pose.height_mm = 60;
  heart.set_camera(pose);
  heart.set_beats(run.last.servo.phase);
  heart.set_cut(CutPlane{.point_mm = tool.dent_place_mm, .normal = pose.towards_viewer});
  const Vec3 line = 255 * heart.look(Structure::Heart).colour;
  const auto line_height = [&](const Picture& picture) {
    const auto x = static_cast<int>(std::lround(heart.pixel_of(tool.dent_place_mm).x()));
    double sum = 0;
    int count = 0;
    for (int y = 0; y < picture.height; ++y) {
      const auto [r, g, b] = colour_at(picture, x, y);
      if (std::abs(r - line.x()) < 14 && std::abs(g - line.y()) < 14 &&
          std::abs(b - line.z()) < 14) {
        sum += y;
        ++count;
      }
    }
    EXPECT_GT(count, 0);
    return sum / std::max(1, count);
  };
  const double natural = line_height(heart.picture(kWidth, kHeight));
  ToolPicture unseen = tool;  // the dent alone: ball and arrow would hide the line
  unseen.position_mm += 500 * pose.up;
  unseen.proxy_mm = unseen.position_mm;
  heart.set_tool(unseen);
  const double pressed = line_height(heart.picture(kWidth, kHeight));
  EXPECT_NEAR(pressed - natural, heart.pixels_per_mm() * tool.dent_mm, kPixels);
}

TEST_F(Pictures, SizesFromTinyToLarge) {
  const auto heart = drawing();
  for (const auto& [width, height] :
       {std::pair{16, 16}, std::pair{200, 150}, std::pair{3840, 2160}}) {
    const Picture picture = heart->picture(width, height);
    EXPECT_EQ(picture.rgb.size(), 3U * static_cast<unsigned>(width * height));
  }
  EXPECT_THROW((void)heart->picture(4, 4), Error);
}

/// Columns of a channel that a body fills, their mean.
double middle_column(const Picture& with, const Picture& without, std::size_t channel) {
  double sum = 0;
  int count = 0;
  for (int y = 0; y < with.height; ++y) {
    for (int x = 0; x < with.width; ++x) {
      if (std::abs(colour_at(with, x, y)[channel] - colour_at(without, x, y)[channel]) < 20) {
        continue;
      }
      sum += x;
      ++count;
    }
  }
  EXPECT_GT(count, 1000);
  return sum / count;
}

TEST_F(Pictures, StereoShowsTheLeftEyeInRedAndWhatIsNearerFartherApart) {
  HeartDrawing stereo(atlas_, nullptr, DrawingOptions{.caption = false, .anaglyph = true});
  CameraPose pose = standard_view(stereo.frame(), "anterior");
  // Right of what the right eye sees lies for the left eye what is nearer than the focus.
  const auto red_right_of_blue = [&](double nearer_mm) {
    CameraPose moved = pose;
    moved.focus_mm = heart_.centre_mm - nearer_mm * pose.towards_viewer;
    stereo.set_camera(moved);
    std::array<Picture, 2> seen;
    for (const bool visible : {false, true}) {
      for (const Structure structure : {Structure::Heart, Structure::LvBlood}) {
        Look look = stereo.look(structure);
        look.opacity = 1;
        look.visible = visible && structure == Structure::Heart;
        stereo.set_look(structure, look);
      }
      seen[visible ? 1 : 0] = stereo.picture(kWidth, kHeight);
    }
    return middle_column(seen[1], seen[0], 0) - middle_column(seen[1], seen[0], 2);
  };
  const double near = red_right_of_blue(60);
  const double far = red_right_of_blue(-60);
  // The eyes look along lines 5 degrees apart.
  const double apart_mm = 2 * 60 * std::sin(2.5 * pi / 180);
  EXPECT_NEAR((near - far) / 2, apart_mm * stereo.pixels_per_mm(), kPixels);
  // What each eye sees of it is shaded otherwise.
  EXPECT_NEAR(near + far, 0, 4 * kPixels);
}

}  // namespace
}  // namespace beatlas::viewer
