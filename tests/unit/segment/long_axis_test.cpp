/// The long axis and the base planes against the phantom's own, and the whole heart segmented.
#include "pipeline/segment/long_axis.h"

#include <numbers>

#include <gtest/gtest.h>

#include "pipeline/phantom/motion.h"
#include "pipeline/segment/chambers.h"
#include "pipeline/segment/segment.h"
#include "tests/unit/segment/imaged_phantom.h"
#include "tests/unit/segment/made_images.h"

namespace beatlas::segment {
namespace {

using Heart = made::ImagedPhantom;

phantom::PhantomSpec small(const Vec3& oblique_deg) {
  phantom::PhantomSpec spec = phantom::preset("small");
  spec.phases = 6;
  spec.oblique_deg = oblique_deg;
  return spec;
}

std::optional<LongAxis> axis_of(const Heart& heart) {
  StageContext context;
  const ImageCycle<float>& stack = heart.exam.stack.images;
  const ImageCycle<float> images = crop(stack, find_moving_box(stack.grid, temporal_stats(stack)));
  const Chambers chambers = find_chambers(images, temporal_stats(images), context);
  return find_long_axis(images, chambers, SegmentOptions{}.tricuspid_excursion_mm);
}

void expect_the_phantoms(const Heart& heart) {
  const std::optional<LongAxis> axis = axis_of(heart);
  ASSERT_TRUE(axis);
  EXPECT_TRUE(axis->atria);
  const phantom::Anatomy& anatomy = heart.phantom.spec().anatomy;
  const Vec3 towards_base = -anatomy.apex_direction_lps.normalized();
  const double turned =
      std::acos(std::min(1.0, axis->towards_base.dot(towards_base))) * 180 / std::numbers::pi;
  EXPECT_LT(turned, 3) << "degrees";

  const phantom::Phantom phantom(heart.phantom.spec());
  const double end_systolic_base = anatomy.apex_mm + anatomy.lv_end_systole.apex_wall_mm +
                                   anatomy.lv_end_systole.length_mm +
                                   anatomy.lv_end_systole.base_mm;
  const double origin = towards_base.dot(axis->origin_mm - anatomy.origin_lps_mm);
  for (int p = 0; p < heart.phantom.spec().phases; ++p) {
    const auto at = static_cast<std::size_t>(p);
    const double loss =
        phantom::volume_loss(phantom.phase_time_s(p), heart.phantom.spec().rr_interval_s);
    const double wanted = (1 - loss) * anatomy.lv_end_diastole.base_mm + loss * end_systolic_base;
    EXPECT_NEAR(origin + axis->lv_base_mm[at], wanted, 1.5) << "phase " << p;
    const double rv =
        (1 - loss) * anatomy.rv_end_diastole.cut_mm + loss * anatomy.rv_end_systole.cut_mm;
    EXPECT_NEAR(origin + axis->rv_base_mm[at], rv, 4) << "phase " << p << ", by rule";
  }
  EXPECT_NEAR(origin + axis->apex_mm[0], anatomy.apex_mm, 8);
}

TEST(LongAxis, IsThePhantomsInAxialSlices) { expect_the_phantoms(Heart(small({0, 0, 0}))); }

TEST(LongAxis, IsThePhantomsInSlicesOfAnyDirection) {
  expect_the_phantoms(Heart(small({25, -20, 40})));
}

/// Fat about as bright as muscle and noise as high as real exams have: beyond the base the walls of
/// the atria look as thick as the ventricle's.
phantom::PhantomSpec low_contrast() {
  phantom::PhantomSpec spec = small({0, 0, 0});
  spec.scanner.signals = phantom::preset("hard").scanner.signals;
  spec.scanner.snr_blood = 10;
  return spec;
}

TEST(LongAxis, EndsWhereTheRingOpensThoughFatLooksLikeMuscle) {
  expect_the_phantoms(Heart(low_contrast()));
}

TEST(LongAxis, HasNoAtriaWhereNothingLiesBeyondTheVentricles) {
  phantom::PhantomSpec spec = small({0, 0, 0});
  spec.anatomy = phantom::ventricles_alone(spec.anatomy);
  const std::optional<LongAxis> axis = axis_of(Heart(spec));
  ASSERT_TRUE(axis);
  EXPECT_FALSE(axis->atria);
}

TEST(LongAxis, HeightsAreThoseOfThePlaces) {
  LongAxis axis;
  axis.origin_mm = {1, 2, 3};
  axis.towards_base = Vec3(1, 2, 2).normalized();
  const Grid grid = made::oblique_grid({3, 4, 5}, {1, 2, 3}, {10, 20, 30});
  const std::vector<float> heights = axis.heights_mm(grid);
  ASSERT_EQ(heights.size(), grid.count());
  const Vec3 at = grid.mm_from_index * Vec3(2, 1, 4);
  EXPECT_NEAR(heights[grid.offset(2, 1, 4)], (at - Vec3(1, 2, 3)).dot(Vec3(1, 2, 2)) / 3, 1e-4);
}

/// Least Dice of the phases.
double least_dice(const Heart& heart, const Segmentation& found, Structure structure) {
  double out = 1;
  for (std::size_t p = 0; p < heart.truth.phases.size(); ++p) {
    out = std::min(out, made::dice(
                            heart.truth.grid.count(),
                            [&](std::size_t v) {
                              return label_in_structure(heart.truth.phases[p][v], structure);
                            },
                            [&](std::size_t v) {
                              return label_in_structure(found.labels.phases[p][v], structure);
                            }));
  }
  return out;
}

TEST(WholeHeart, ItsVentriclesEndAtTheirValves) {
  const Heart heart(small({0, 0, 0}));
  StageContext context;
  const Segmentation found = segment_exam(heart.exam, {}, {}, context);
  EXPECT_GE(least_dice(heart, found, Structure::LvBlood), 0.97);
  // Published networks' mean on real cine.
  EXPECT_GE(least_dice(heart, found, Structure::RvBlood), 0.923);
  EXPECT_GE(least_dice(heart, found, Structure::LvMyocardium), 0.92);
  EXPECT_GE(least_dice(heart, found, Structure::Heart), 0.95)
      << "with atria and the aortic root, without fat";
}

TEST(WholeHeart, IsFoundThoughFatLooksLikeMuscle) {
  const Heart heart(low_contrast());
  StageContext context;
  const Segmentation found = segment_exam(heart.exam, {}, {}, context);
  // The limits of the preset `hard`, whose voxels hold a fifth of these.
  EXPECT_GE(least_dice(heart, found, Structure::LvBlood), 0.93);
  EXPECT_GE(least_dice(heart, found, Structure::RvBlood), 0.90);
  EXPECT_GE(least_dice(heart, found, Structure::LvMyocardium), 0.85);
  EXPECT_GE(least_dice(heart, found, Structure::Heart), 0.94);
}

}  // namespace
}  // namespace beatlas::segment
