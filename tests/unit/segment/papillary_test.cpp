/// Papillary muscles in the cavity or in the wall, against the phantom's volumes.
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

}  // namespace
}  // namespace beatlas::segment
