/// Papillary muscles in the cavity or in the wall, against the phantom's volumes.
#include "pipeline/segment/papillary.h"

#include <algorithm>
#include <iostream>

#include <gtest/gtest.h>

#include "pipeline/core/segmented_volume.h"
#include "pipeline/segment/segment.h"
#include "tests/made_images.h"
#include "tests/unit/segment/imaged_phantom.h"

namespace beatlas::segment {
namespace {

TEST(Papillary, AreCavityOrWallAsIsAsked) {
  phantom::PhantomSpec spec = phantom::preset("small");
  spec.anatomy = phantom::ventricles_alone(spec.anatomy);
  spec.anatomy.papillary_muscles.present = true;
  spec.phases = 6;
  const made::ImagedPhantom imaged(spec, made::Views::All);
  SegmentOptions options;
  const Segmentation in = imaged.segmented({}, options);
  options.papillary = Papillary::Muscle;
  const Segmentation out = imaged.segmented({}, options);
  const auto curve = [](const Segmentation& of, Structure structure) {
    return segmented_volume_ml(of, structure);
  };
  const auto in_blood = curve(in, Structure::LvBlood);
  const auto out_blood = curve(out, Structure::LvBlood);
  const auto in_wall = curve(in, Structure::LvMyocardium);
  const auto out_wall = curve(out, Structure::LvMyocardium);
  const double full = imaged.phantom.volume_ml(Structure::LvBlood, 0);
  double moved = 0;
  double muscles = 0;
  for (int p = 0; p < spec.phases; ++p) {
    const auto at = static_cast<std::size_t>(p);
    const double t = imaged.phantom.phase_time_s(p);
    const double blood = imaged.phantom.volume_ml(Structure::LvBlood, t);
    const double papillary = imaged.phantom.volume_ml(phantom::Part::PapillaryMuscles, t);
    // 3 %: what the end-diastolic volume may be off.
    EXPECT_NEAR(in_blood[at], blood, 0.03 * full) << p;
    EXPECT_NEAR(out_blood[at], blood - papillary, 0.03 * full) << p;
    EXPECT_NEAR(out_wall[at] - in_wall[at], in_blood[at] - out_blood[at], 0.3 * papillary) << p;
    moved += in_blood[at] - out_blood[at];
    muscles += papillary;
    std::cout << "phase " << p << ": " << in_blood[at] - out_blood[at] << " ml for " << papillary
              << "\n";
  }
  // Their ends, where voxels of 2 x 2 x 4 mm are half blood, are hard to see.
  EXPECT_NEAR(moved / muscles, 1, 0.3);
  // What is cavity and what is wall does not move the others, but where edges meet: the outside is
  // measured against the tissue inside it, and behind a thin wall that is the papillary muscle.
  constexpr double kShare = 5e-4;
  for (const Structure structure : {Structure::RvBlood, Structure::Heart}) {
    for (std::size_t p = 0; p < in_blood.size(); ++p) {
      const double before = curve(in, structure)[p];
      EXPECT_NEAR(before, curve(out, structure)[p], kShare * before) << p;
    }
  }
}

TEST(Papillary, ADarkRimIsNoMuscleAndASpeckIsNoise) {
  const Grid grid = made::straight_grid({40, 40, 1}, {1, 1, 8});
  ImageCycle<float> images = made::constant_images(grid, 1, 1000);
  ImageCycle<std::uint8_t> labels{grid, {std::vector<std::uint8_t>(grid.count(), kLabelLvBlood)}};
  const auto darken = [&](int i0, int i1, int j0, int j1) {
    for (int j = j0; j < j1; ++j) {
      for (int i = i0; i < i1; ++i) images.phases[0][grid.offset(i, j, 0)] = 300;
    }
  };
  darken(0, 2, 0, 40);     // a rim
  darken(30, 31, 30, 31);  // a speck
  darken(15, 24, 15, 24);  // a muscle
  tissue::TissueLevels levels;
  levels.blood = 1000;
  levels.muscle = 300;
  levels.threshold = 650;
  papillary_muscles_to_wall(images, levels, labels);
  EXPECT_EQ(labels.phases[0][grid.offset(0, 20, 0)], kLabelLvBlood);
  EXPECT_EQ(labels.phases[0][grid.offset(30, 30, 0)], kLabelLvBlood);
  EXPECT_EQ(labels.phases[0][grid.offset(19, 19, 0)], kLabelLvMyocardium);
  const auto count = std::count(labels.phases[0].begin(), labels.phases[0].end(),
                                std::uint8_t{kLabelLvMyocardium});
  EXPECT_NEAR(static_cast<double>(count), 81, 16) << "its corners are rounded off";
}

}  // namespace
}  // namespace beatlas::segment
