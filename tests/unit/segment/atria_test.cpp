/// Atria and the root of the aorta as structures of their own, on phantoms whose truth is known.
#include "pipeline/segment/atria.h"

#include <algorithm>
#include <cmath>
#include <iostream>

#include <gtest/gtest.h>

#include "pipeline/core/segmented_volume.h"
#include "pipeline/segment/segment.h"
#include "tests/unit/segment/imaged_phantom.h"
#include "tests/unit/segment/made_images.h"

namespace beatlas::segment {
namespace {

using Case = made::ImagedPhantom;

struct Wanted {
  double dice = 0;          ///< at least, in every phase
  double volume_share = 0;  ///< at most, off the true volume, in every phase
};

void expect_atria(const Case& made, const Wanted& wanted) {
  StageContext context;
  const Segmentation found = segment_exam(made.exam, {}, {}, context);
  for (const Structure structure : kBeyondBase) {
    SCOPED_TRACE(structure_name(structure));
    ASSERT_EQ(found.coverage.phases.count(structure), 1U);
    const std::vector<double> volume_ml = segmented_volume_ml(found, structure);
    double least = 1;
    double off = 0;
    for (std::size_t p = 0; p < found.labels.phases.size(); ++p) {
      const double truth =
          made.phantom.volume_ml(structure, made.phantom.phase_time_s(static_cast<int>(p)));
      off = std::max(off, std::abs(volume_ml[p] / truth - 1));
      least = std::min(least, made::dice(
                                  made.truth.grid.count(),
                                  [&](std::size_t v) {
                                    return label_in_structure(made.truth.phases[p][v], structure);
                                  },
                                  [&](std::size_t v) {
                                    return label_in_structure(found.labels.phases[p][v], structure);
                                  }));
    }
    std::cout << structure_name(structure) << ": least Dice " << least << ", volume off by "
              << 100 * off << " % at most\n";
    EXPECT_GT(least, wanted.dice);
    EXPECT_LT(off, wanted.volume_share);
  }
}

TEST(Atria, of_the_small_phantom_are_told_apart) {
  expect_atria(Case(phantom::preset("small")), {0.9, 0.1});
}

TEST(Atria, are_told_apart_in_noise_and_from_another_direction) {
  phantom::PhantomSpec spec = phantom::preset("small");
  spec.scanner.snr_blood = 10;
  spec.oblique_deg = {14, -9, 25};
  expect_atria(Case(spec), {0.85, 0.15});
}

TEST(Atria, are_none_where_none_are) {
  phantom::PhantomSpec spec = phantom::preset("small");
  spec.anatomy = phantom::ventricles_alone(spec.anatomy);
  StageContext context;
  const Segmentation found = segment_exam(Case(spec).exam, {}, {}, context);
  for (const Structure structure : kBeyondBase) {
    EXPECT_EQ(found.coverage.phases.count(structure), 0U) << structure_name(structure);
  }
}

TEST(Atria, change_nothing_else) {
  const Case made(phantom::preset("small"));
  StageContext context;
  SegmentOptions without;
  without.atria = false;
  const Segmentation whole = segment_exam(made.exam, {}, without, context);
  Segmentation parted = segment_exam(made.exam, {}, {}, context);
  for (auto& phase : parted.labels.phases) {
    std::transform(phase.begin(), phase.end(), phase.begin(), ventricles_apart);
  }
  EXPECT_EQ(parted.labels.phases, whole.labels.phases);
  for (const Structure structure : kVentricular) {
    EXPECT_EQ(parted.coverage.phases.at(structure), whole.coverage.phases.at(structure));
  }
  for (const Structure structure : kBeyondBase) {
    EXPECT_EQ(whole.coverage.phases.count(structure), 0U);
  }
}

}  // namespace
}  // namespace beatlas::segment
