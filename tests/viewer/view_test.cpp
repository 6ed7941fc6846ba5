/// What a picture shows before anybody turns it: all of the heart, its names and their colours.

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "runtime/atlas/structure_colours.h"
#include "runtime/viewer/display.h"
#include "runtime/viewer/drawing.h"
#include "tests/viewer/ellipsoid.h"

namespace beatlas::viewer {
namespace {

class View : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    display_ = std::make_unique<Display>();
    folder_ = std::make_unique<test::TemporaryFolder>();
    atlas_ = test::ellipsoid_atlas(*folder_, {}, 12, 4);
  }
  static void TearDownTestSuite() {
    atlas_.reset();
    folder_.reset();
    display_.reset();
  }
  static HeartDrawing drawing(const DrawingOptions& options) { return {atlas_, nullptr, options}; }

  static inline std::unique_ptr<Display> display_;
  static inline std::unique_ptr<test::TemporaryFolder> folder_;
  static inline std::shared_ptr<const atlas::Atlas> atlas_;
};

struct Extent {
  Vec2 low = Vec2::Constant(1e9);
  Vec2 high = Vec2::Constant(-1e9);
};

// Of all that is drawn through the beat, in pixels of the last picture.
Extent extent_of(HeartDrawing& heart) {
  Extent extent;
  for (int n = 0; n < 12; ++n) {
    heart.set_beats(n / 12.0);
    for (const Structure structure : kAllStructures) {
      for (const Vec3f& x : heart.drawn_vertices(structure)) {
        const Vec2 at = heart.pixel_of(x.cast<double>());
        extent.low = extent.low.cwiseMin(at);
        extent.high = extent.high.cwiseMax(at);
      }
    }
  }
  return extent;
}

TEST_F(View, FitsTheHeartFromEverySideInAPictureOfAnyShape) {
  HeartDrawing heart = drawing({.caption = false});
  for (const std::string_view view : kViews) {
    heart.fit_camera(standard_view(heart.frame(), view));
    for (const auto& [width, height] :
         {std::pair{640, 480}, std::pair{220, 700}, std::pair{900, 200}}) {
      (void)heart.picture(width, height);
      const Vec2 size(width, height);
      const Extent extent = extent_of(heart);
      const Vec2 share = (extent.high - extent.low).cwiseQuotient(size);
      EXPECT_GE(extent.low.minCoeff(), 0) << view << width;
      EXPECT_LE((extent.high - size).maxCoeff(), 0) << view << width;
      EXPECT_NEAR(share.maxCoeff(), 1 / 1.2, 0.01) << view << width << ": it fills the picture";
      const Vec2 middle = 0.5 * (extent.low + extent.high + Vec2::Ones());
      EXPECT_LT((middle - 0.5 * size).norm(), 1) << view << width;
    }
  }
  heart.fit_camera(standard_view(heart.frame(), "left"), 2);
  (void)heart.picture(640, 480);
  const Extent twice = extent_of(heart);
  EXPECT_NEAR((twice.high - twice.low).cwiseQuotient(Vec2(640, 480)).maxCoeff(), 2 / 1.2, 0.02);
  // Who has chosen a view keeps it.
  CameraPose chosen = heart.camera();
  chosen.height_mm = 77;
  heart.set_camera(chosen);
  (void)heart.picture(220, 700);
  EXPECT_NEAR(heart.camera().height_mm, 77, 1e-9);
}

TEST_F(View, TheCaptionNamesEndDiastoleAndEndSystole) {
  HeartDrawing heart = drawing({});
  const atlas::Manifest& manifest = atlas_->manifest();
  ASSERT_NE(manifest.end_diastole, manifest.end_systole);
  for (int phase = 0; phase < 12; ++phase) {
    // The name holds as long as no other phase is nearer.
    for (const double off : {-0.49, 0.0, 0.49}) {
      heart.set_beats((phase + off) / 12);
      const std::string words = heart.caption();
      EXPECT_EQ(words.find("end-diastole (ED)") != std::string::npos,
                phase == manifest.end_diastole)
          << words;
      EXPECT_EQ(words.find("end-systole (ES)") != std::string::npos, phase == manifest.end_systole)
          << words;
    }
  }
  heart.set_beats(0.25);
  heart.set_note("4.0 mm deep");
  EXPECT_TRUE(heart.caption().starts_with("25 % of the beat")) << heart.caption();
  EXPECT_TRUE(heart.caption().ends_with("   4.0 mm deep")) << heart.caption();
}

// Pixels of exactly a structure's colour beside the names: its swatch.
int swatch_pixels(const Picture& picture, Structure structure) {
  const Colour colour = structure_colour(structure);
  int count = 0;
  for (int y = 0; y < picture.height / 3; ++y) {
    for (int x = 0; x < picture.width / 12; ++x) {
      const auto at = 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) +
                           static_cast<std::size_t>(x));
      count += std::equal(colour.begin(), colour.end(), picture.rgb.begin() + std::ptrdiff_t(at));
    }
  }
  return count;
}

// Pixels of the top line's words.
int bright_pixels(const Picture& picture, int rows) {
  int count = 0;
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const auto at = 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) +
                           static_cast<std::size_t>(x));
      count += picture.rgb[at] > 150 && picture.rgb[at + 1] > 150 && picture.rgb[at + 2] > 150;
    }
  }
  return count;
}

TEST_F(View, NamesStandBesideTheColourItself) {
  const Picture picture = drawing({}).picture(800, 600);
  EXPECT_NEAR(swatch_pixels(picture, Structure::Heart), 12 * 12, 26);
  EXPECT_NEAR(swatch_pixels(picture, Structure::LvBlood), 12 * 12, 26);
  EXPECT_EQ(swatch_pixels(picture, Structure::Aorta), 0) << "there is none";
  HeartDrawing heart = drawing({});
  for (const Structure structure : kAllStructures) {
    Look look = heart.look(structure);
    look.opacity = 0;
    heart.set_look(structure, look);
  }
  EXPECT_EQ(swatch_pixels(heart.picture(800, 600), Structure::LvBlood), 0) << "nothing is seen";
  heart.set_cut(standard_cut(heart.frame(), "four-chamber", 0));
  EXPECT_NEAR(swatch_pixels(heart.picture(800, 600), Structure::LvBlood), 12 * 12, 26)
      << "its outline is seen";
}

TEST_F(View, WordsGrowByTheWishAndOnADisplayOfFinePixels) {
  const Picture usual = drawing({}).picture(800, 600);
  const Picture wished = drawing({.text_scale = 2}).picture(800, 600);
  const Picture fine = drawing({.display_scale = 2}).picture(800, 600);
  EXPECT_NEAR(swatch_pixels(wished, Structure::Heart), 24 * 24, 50);
  EXPECT_GT(bright_pixels(wished, 60), 2.5 * bright_pixels(usual, 30));
  EXPECT_EQ(wished.rgb, fine.rgb);
  EXPECT_EQ(drawing({.display_scale = 0.5}).picture(800, 600).rgb, usual.rgb) << "never smaller";
}

// The muscle's outline is the heart's where no ventricle lies outside: not a mixture of both.
TEST_F(View, OfTwoOutlinesThatAreOneTheInnersIsSeen) {
  const auto coinciding = test::ellipsoid_atlas(*folder_, {}, 4, 4, 1e-7);
  HeartDrawing heart(coinciding, nullptr, {.caption = false});
  for (const Structure structure : kAllStructures) {
    Look look = heart.look(structure);
    look.opacity = 0;
    look.visible = structure == Structure::Heart || structure == Structure::LvMyocardium;
    heart.set_look(structure, look);
  }
  for (const std::string_view cut : kCuts) {
    const CutPlane plane = standard_cut(heart.frame(), cut, 0);
    CameraPose pose = standard_view(heart.frame(), "anterior");
    pose.towards_viewer = plane.normal;
    pose.up = plane.normal.unitOrthogonal();
    heart.set_camera(pose);
    heart.set_cut(plane);
    const Picture picture = heart.picture(640, 480);
    const auto pixels_like = [&](Structure structure) {
      const Colour colour = structure_colour(structure);
      int count = 0;
      for (std::size_t at = 0; at < picture.rgb.size(); at += 3) {
        int most = 0;
        for (std::size_t n = 0; n < 3; ++n) {
          most = std::max(most, std::abs(int{picture.rgb[at + n]} - int{colour[n]}));
        }
        count += most < 14;
      }
      return count;
    };
    const int inner = pixels_like(Structure::LvMyocardium);
    EXPECT_GT(inner, 500) << cut;
    EXPECT_LT(pixels_like(Structure::Heart), 0.02 * inner) << cut;
  }
}

}  // namespace
}  // namespace beatlas::viewer
