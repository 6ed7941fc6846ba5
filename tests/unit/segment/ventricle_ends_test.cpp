/// The axis, apex and base that a segmentation keeps, against the phantom's closed form.
#include "pipeline/segment/ventricle_ends.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <numbers>

#include <gtest/gtest.h>

#include "pipeline/phantom/motion.h"
#include "pipeline/segment/edited_labels.h"
#include "pipeline/segment/known_labels.h"
#include "pipeline/segment/segment.h"
#include "tests/clinical_part.h"
#include "tests/made_images.h"
#include "tests/unit/segment/imaged_phantom.h"

namespace beatlas::segment {
namespace {

using Heart = made::ImagedPhantom;

phantom::PhantomSpec small(bool alone, int phases, const Vec3& oblique_deg = Vec3::Zero()) {
  phantom::PhantomSpec spec = phantom::preset("small");
  spec.phases = phases;
  spec.oblique_deg = oblique_deg;
  if (alone) spec.anatomy = phantom::ventricles_alone(spec.anatomy);
  return spec;
}

struct Tolerance {
  double degrees, apex_mm, lv_mm, rv_mm;
};

void expect_the_phantoms(const phantom::PhantomSpec& spec, const std::optional<LongAxis>& axis,
                         const Tolerance& most) {
  ASSERT_TRUE(axis);
  const phantom::Anatomy& anatomy = spec.anatomy;
  const Vec3 towards_base = -anatomy.apex_direction_lps.normalized();
  EXPECT_NEAR(axis->towards_base.norm(), 1, 1e-9);
  const double turned =
      std::acos(std::min(1.0, axis->towards_base.dot(towards_base))) * 180 / std::numbers::pi;
  EXPECT_LT(turned, most.degrees);
  const auto n = static_cast<std::size_t>(spec.phases);
  ASSERT_EQ(axis->apex_mm.size(), n);
  ASSERT_EQ(axis->lv_base_mm.size(), n);
  ASSERT_EQ(axis->rv_base_mm.size(), n);
  const phantom::Phantom phantom(spec);
  const double end_systolic_base = anatomy.apex_mm + anatomy.lv_end_systole.apex_wall_mm +
                                   anatomy.lv_end_systole.length_mm +
                                   anatomy.lv_end_systole.base_mm;
  // A plane is looked for where its ventricle is: beside the axis, planes across one that is turned
  // by a degree lie a millimetre higher or lower.
  const auto height = [&](const Vec3& beside, double mm) {
    const Vec3 in_plane = beside + (mm - axis->height_mm(beside)) * axis->towards_base;
    return towards_base.dot(in_plane - anatomy.origin_lps_mm);
  };
  const Vec3 towards_rv =
      (anatomy.rv_direction_lps - anatomy.rv_direction_lps.dot(towards_base) * towards_base)
          .normalized();
  const Vec3 rv_middle = anatomy.origin_lps_mm + anatomy.rv_end_diastole.centre_x_mm * towards_rv;
  // The RV lies on both sides of its own direction alike.
  ASSERT_TRUE(axis->rv_centre_mm);
  const Vec3 to_rv = *axis->rv_centre_mm - axis->origin_mm;
  const Vec3 across = to_rv - to_rv.dot(towards_base) * towards_base;
  const double off_septum = std::atan2(across.cross(towards_rv).norm(), across.dot(towards_rv));
  EXPECT_LT(off_septum * 180 / std::numbers::pi, 5) << "of the 60 of a segment";
  Vec3 worst = Vec3::Zero();
  for (std::size_t p = 0; p < n; ++p) {
    const double loss =
        phantom::volume_loss(phantom.phase_time_s(static_cast<int>(p)), spec.rr_interval_s);
    const double lv = (1 - loss) * anatomy.lv_end_diastole.base_mm + loss * end_systolic_base;
    const double rv =
        (1 - loss) * anatomy.rv_end_diastole.cut_mm + loss * anatomy.rv_end_systole.cut_mm;
    const Vec3 off = Vec3(height(axis->origin_mm, axis->apex_mm[p]) - anatomy.apex_mm,
                          height(axis->origin_mm, axis->lv_base_mm[p]) - lv,
                          height(rv_middle, axis->rv_base_mm[p]) - rv);
    EXPECT_LT(std::abs(off[0]), most.apex_mm) << "apex, phase " << p << ": " << off[0];
    EXPECT_LT(std::abs(off[1]), most.lv_mm) << "LV's base, phase " << p << ": " << off[1];
    EXPECT_LT(std::abs(off[2]), most.rv_mm) << "RV's base, phase " << p << ": " << off[2];
    worst = worst.cwiseMax(off.cwiseAbs());
  }
  std::cout << "axis " << turned << " degrees off; apex " << worst[0] << ", LV's base " << worst[1]
            << ", RV's base " << worst[2] << " mm at most\n";
  // Shares of the length: apex, base.
  const Vec3 apex = anatomy.origin_lps_mm + anatomy.apex_mm * towards_base;
  EXPECT_NEAR(axis->share_of_length(apex, 0), 0, most.apex_mm / 90);
}

std::optional<LongAxis> segmented_axis(const Heart& heart) { return heart.segmented().axis; }

/// What no atrium hides is told within half a slice. Where an atrium follows no edge shows the
/// valve, and the prior tells it: within its slices of 4 mm, the tricuspid one within one and a
/// half.
constexpr Tolerance kThin{4, 2, 1.5, 1.5};
constexpr Tolerance kThinWithAtria{4, 2, 4, 6};
/// In slices that lie neither across nor along the LV the prior takes the root of the phantom's
/// aorta, which has no valve, for outflow tract at end-systole; 4 mm with the weights before, which
/// patients are worse off with.
constexpr Tolerance kThinAskew{4, 2, 20, 6};

TEST(VentricleAxis, IsThePhantomsWithAtria) {
  const Heart heart(small(false, 4), made::Views::All);
  expect_the_phantoms(heart.phantom.spec(), segmented_axis(heart), kThinWithAtria);
}

TEST(VentricleAxis, IsThePhantomsInSlicesOfAnyDirection) {
  const Heart heart(small(false, 4, {25, -20, 40}), made::Views::All);
  expect_the_phantoms(heart.phantom.spec(), segmented_axis(heart), kThinAskew);
}

TEST(VentricleAxis, IsThePhantomsWithVentriclesAlone) {
  const Heart heart(small(true, 4), made::Views::All);
  expect_the_phantoms(heart.phantom.spec(), segmented_axis(heart), kThin);
}

/// A plane between two thick slices is none across an LV that leans: it met the axis 24 mm above
/// the base here.
TEST(VentricleAxis, OfThickSlicesThatLieAskewEndsWhereTheLabelsDo) {
  phantom::PhantomSpec spec = small(true, 4);  // whose LV leans by 42 degrees
  spec.grid = phantom::on_matrix(spec.grid, {0, 0, 0}, {2, 2, 8});
  const Heart heart(spec, made::Views::All);
  StageContext context;
  const Segmentation known =
      segment_with_labels(heart.exam, {heart.truth, {0, 1, 2, 3}}, {}, {}, context);
  expect_the_phantoms(heart.phantom.spec(), known.axis, {6, 4, 4, 4});
}

/// A tube of muscle about blood through every slice.
Segmentation tube() {
  Segmentation out;
  out.labels.grid = made::straight_grid({24, 24, 5}, {2, 2, 8});
  const Grid& grid = out.labels.grid;
  std::vector<std::uint8_t> phase(grid.count());
  for_each_voxel(grid, [&](int i, int j, int, std::size_t v) {
    const double r = std::hypot(i - 12, j - 12);
    phase[v] = r < 6 ? kLabelLvBlood : r < 9 ? kLabelLvMyocardium : kLabelBackground;
  });
  out.labels.phases.assign(2, phase);
  return out;
}
void cover_as_labelled(Segmentation& of) {
  of.coverage.grid = of.labels.grid;
  for (const Structure structure : {Structure::LvBlood, Structure::LvMyocardium}) {
    for (const std::vector<std::uint8_t>& phase : of.labels.phases) {
      std::vector<float>& share = of.coverage.phases[structure].emplace_back(phase.size());
      std::transform(phase.begin(), phase.end(), share.begin(), [&](std::uint8_t label) {
        return label_in_structure(label, structure) ? 1.0F : 0.0F;
      });
    }
  }
}

TEST(CutEnds, AreToldWhereTheImagesEndWithinTheVentricle) {
  Segmentation cut = tube();
  cover_as_labelled(cut);
  const std::vector<std::string> both = cut_ends(cut, 1);
  ASSERT_EQ(both.size(), 2U);
  EXPECT_NE(both[0].find("its base lies beyond slice 4"), std::string::npos) << both[0];
  EXPECT_NE(both[1].find("its apex lies beyond slice 0"), std::string::npos) << both[1];
  EXPECT_NE(cut_ends(cut, -1)[0].find("its base lies beyond slice 0"), std::string::npos);

  // Open to the left ventricle's outflow in the last slice, and tapering towards the first.
  Segmentation whole = tube();
  const Grid& grid = whole.labels.grid;
  for (std::vector<std::uint8_t>& phase : whole.labels.phases) {
    for_each_voxel(grid, [&](int i, int j, int k, std::size_t v) {
      if (k == 4 && j < 6 && std::abs(i - 12) < 3) phase[v] = kLabelRestOfHeart;
      if (k == 0 && std::hypot(i - 12, j - 12) > 5) phase[v] = kLabelBackground;
      if (k == 0 && phase[v] == kLabelLvBlood) phase[v] = kLabelLvMyocardium;
    });
  }
  whole.labels.phases[0][grid.offset(12, 6, 4)] = kLabelLvBlood;
  cover_as_labelled(whole);
  EXPECT_TRUE(cut_ends(whole, 1).empty());
}

TEST(VentricleAxis, OfLabelsAloneIsTheirs) {
  const Heart heart(small(true, 6), made::Views::All);
  StageContext context;
  const Segmentation known =
      segment_with_labels(heart.exam, {heart.truth, {0, 1, 2, 3, 4, 5}}, {}, {}, context);
  expect_the_phantoms(heart.phantom.spec(), known.axis, {3, 2, 1.5, 1.5});
}

TEST(VentricleAxis, InThickSlicesIsWithinASlice) {
  phantom::PhantomSpec spec = made::clinical_part();
  spec.phases = 8;
  spec.anatomy = phantom::ventricles_alone(spec.anatomy);
  const Heart heart(spec, made::Views::All);
  expect_the_phantoms(heart.phantom.spec(), segmented_axis(heart), {4, 7, 5, 5});
}

TEST(VentricleAxis, FollowsLabelsThatAreCutInOnePhase) {
  const Heart heart(small(true, 6), made::Views::All);
  StageContext context;
  const Segmentation made =
      segment_with_labels(heart.exam, {heart.truth, {0, 1, 2, 3, 4, 5}}, {}, {}, context);
  ASSERT_TRUE(made.axis);
  // Everything of the LV within 20 mm of its base becomes the rest of the heart.
  LabelCycle labels = made.labels;
  for (std::size_t v = 0; v < labels.grid.count(); ++v) {
    const auto k = static_cast<int>(v / labels.grid.slice_count());
    const auto j = static_cast<int>(v % labels.grid.slice_count() /
                                    static_cast<std::size_t>(labels.grid.size[0]));
    const auto i = static_cast<int>(v % static_cast<std::size_t>(labels.grid.size[0]));
    const double height = made.axis->height_mm(labels.grid.mm(i, j, k));
    std::uint8_t& label = labels.phases[2][v];
    if (height > made.axis->lv_base_mm[2] - 20 &&
        (label == kLabelLvBlood || label == kLabelLvMyocardium)) {
      label = kLabelRestOfHeart;
    }
  }
  const Segmentation edited = with_edited_labels(made, labels, context);
  ASSERT_TRUE(edited.axis);
  EXPECT_NEAR(edited.axis->lv_base_mm[2], made.axis->lv_base_mm[2] - 20, 1.5);
  EXPECT_NEAR(edited.axis->apex_mm[2], made.axis->apex_mm[2], 1.5);
  for (const std::size_t p : {0, 1, 3, 4, 5}) {
    EXPECT_EQ(edited.axis->lv_base_mm[p], made.axis->lv_base_mm[p]);
    EXPECT_EQ(edited.axis->apex_mm[p], made.axis->apex_mm[p]);
  }
}

TEST(VentricleAxis, IsNoneWithoutAVentricle) {
  const Grid grid = made::straight_grid({20, 20, 6}, {2, 2, 4});
  Segmentation heart;
  heart.labels = {grid, {std::vector<std::uint8_t>(grid.count(), kLabelRestOfHeart)}};
  heart.coverage.grid = grid;
  heart.coverage.phases[Structure::Heart] = {std::vector<float>(grid.count(), 1.0F)};
  EXPECT_FALSE(ventricle_axis(heart));
}

}  // namespace
}  // namespace beatlas::segment
