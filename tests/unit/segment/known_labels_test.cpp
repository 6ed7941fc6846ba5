/// Labels from elsewhere, of all phases or of some, on phantoms whose truth is known.
#include "pipeline/segment/known_labels.h"

#include <algorithm>
#include <numeric>

#include <gtest/gtest.h>

#include "pipeline/core/parallel.h"
#include "pipeline/core/segmented_volume.h"
#include "tests/clinical_part.h"
#include "tests/made_images.h"
#include "tests/unit/segment/imaged_phantom.h"

namespace beatlas::segment::known_labels_tests {
namespace {

using Case = made::ImagedPhantom;

// Of six phases: between end-diastole and end-systole, and back, lie two that are not known.
phantom::PhantomSpec small_whole() {
  phantom::PhantomSpec spec = phantom::preset("small");
  spec.phases = 6;
  return spec;
}

phantom::PhantomSpec small_ventricles() {
  phantom::PhantomSpec spec = small_whole();
  spec.anatomy = phantom::ventricles_alone(spec.anatomy);
  return spec;
}

const Case& small_case() {
  static const Case made(small_ventricles(), made::Views::All);
  return made;
}

const Case& whole_case() {
  static const Case made(small_whole(), made::Views::All);
  return made;
}

int end_systole(const Case& made) {
  int emptiest = 0;
  for (int p = 0; p < made.truth.phase_count(); ++p) {
    const auto volume = [&](int q) {
      return made.phantom.volume_ml(Structure::LvBlood, made.phantom.phase_time_s(q));
    };
    if (volume(p) < volume(emptiest)) emptiest = p;
  }
  return emptiest;
}

KnownLabels known_of(const LabelCycle& truth, const std::vector<int>& phases) {
  KnownLabels known{{truth.grid, {}}, phases};
  for (const int p : phases) {
    known.labels.phases.push_back(truth.phases[static_cast<std::size_t>(p)]);
  }
  return known;
}

Segmentation segmented(const Case& made, const KnownLabels& known,
                       const std::vector<Seed>& seeds = {}) {
  StageContext context;
  return segment_with_labels(made.exam, known, seeds, {}, context, {}, &made.prior());
}

double dice_of(const Case& made, const Segmentation& result, Structure structure, std::size_t p) {
  return made::dice(
      made.truth.grid.count(),
      [&](std::size_t v) { return label_in_structure(made.truth.phases[p][v], structure); },
      [&](std::size_t v) { return label_in_structure(result.labels.phases[p][v], structure); });
}

TEST(KnownLabels, OfEndDiastoleAndEndSystoleMakeTheOtherPhasesBetterThanNone) {
  const Case& made = small_case();
  const int es = end_systole(made);
  const Segmentation automatic = made.segmented();
  const Segmentation led = segmented(made, known_of(made.truth, {0, es}));
  for (const Structure structure : kVentricular) {
    double before = 0;
    double after = 0;
    double least_before = 1;
    double least_after = 1;
    int others = 0;
    for (int p = 0; p < made.truth.phase_count(); ++p) {
      const auto at = static_cast<std::size_t>(p);
      if (p == 0 || p == es) {
        EXPECT_EQ(led.labels.phases[at], made.truth.phases[at]) << "as given";
        continue;
      }
      before += dice_of(made, automatic, structure, at);
      after += dice_of(made, led, structure, at);
      least_before = std::min(least_before, dice_of(made, automatic, structure, at));
      least_after = std::min(least_after, dice_of(made, led, structure, at));
      ++others;
    }
    std::cout << structure_name(structure) << ": mean Dice of the " << others << " other phases "
              << before / others << " automatic, " << after / others << " with ED and ES; least "
              << least_before << ", " << least_after << "\n";
    // Where both are right but for the voxels of the boundary, none is the better one.
    constexpr double kVoxels = 5e-4;
    EXPECT_GE(after / others, before / others - kVoxels) << structure_name(structure);
    EXPECT_GE(least_after, least_before - kVoxels) << structure_name(structure);
  }
}

TEST(KnownLabels, PartVentriclesFromAtriaInThePhasesBetween) {
  // Thin slices and the whole heart: no edge parts the blood of ventricles and atria.
  const Case& made = whole_case();
  const int es = end_systole(made);
  const Segmentation led = segmented(made, known_of(made.truth, {0, es}));
  // What networks reach on real cine, for chambers whose open side no image shows.
  for (const auto& [structure, demand] :
       {std::pair{Structure::Heart, 0.95}, std::pair{Structure::LvBlood, 0.93},
        std::pair{Structure::RvBlood, 0.90}, std::pair{Structure::LvMyocardium, 0.92}}) {
    double least = 1;
    for (int p = 0; p < made.truth.phase_count(); ++p) {
      least = std::min(least, dice_of(made, led, structure, static_cast<std::size_t>(p)));
    }
    std::cout << structure_name(structure) << ": least Dice " << least << "\n";
    EXPECT_GE(least, demand) << structure_name(structure);
  }
}

TEST(KnownLabels, OfOnePhaseMakeNoOtherWorse) {
  // What an editor hands back of a phase, painted or not, must not cost the phases it left alone.
  for (const bool whole : {false, true}) {
    const Case& made = whole ? whole_case() : small_case();
    const Segmentation automatic = made.segmented();
    for (const int phase : {0, end_systole(made)}) {
      SCOPED_TRACE((whole ? "whole, phase " : "ventricles, phase ") + std::to_string(phase));
      const Segmentation led = segmented(made, known_of(automatic.labels, {phase}));
      for (const Structure structure : kVentricular) {
        double lost = 0;
        for (int p = 0; p < made.truth.phase_count(); ++p) {
          const auto at = static_cast<std::size_t>(p);
          lost = std::max(
              lost, dice_of(made, automatic, structure, at) - dice_of(made, led, structure, at));
        }
        std::cout << structure_name(structure) << ": Dice falls by " << lost << " at most\n";
        // A valve plane that is known in one phase pulls those beside it by a part of a slice.
        EXPECT_LT(lost, 0.015) << structure_name(structure);
      }
    }
  }
}

TEST(KnownLabels, OfAllPhasesAreTakenAsTheyAre) {
  const Case& made = small_case();
  std::vector<int> all(static_cast<std::size_t>(made.truth.phase_count()));
  std::iota(all.begin(), all.end(), 0);
  const Segmentation result = segmented(made, known_of(made.truth, all));
  EXPECT_EQ(result.labels.phases, made.truth.phases);
  EXPECT_TRUE(result.warnings.empty());
  EXPECT_TRUE(result.valve_planes.empty());
  EXPECT_EQ(result.end_systole, end_systole(made));
  for (const Structure structure : kVentricular) {
    const std::vector<double> curve = segmented_volume_ml(result, structure);
    for (std::size_t p = 0; p < curve.size(); ++p) {
      const double voxels = static_cast<double>(
          std::count_if(made.truth.phases[p].begin(), made.truth.phases[p].end(),
                        [&](std::uint8_t label) { return label_in_structure(label, structure); }));
      // Smoothing takes pi sigma^2 pixels of each outline of some hundred: a few percent.
      EXPECT_NEAR(curve[p], voxels * made.truth.grid.voxel_ml(),
                  0.05 * voxels * made.truth.grid.voxel_ml())
          << structure_name(structure) << " " << p;
    }
  }
}

TEST(KnownLabels, WithoutAStructureLeaveItToThePrior) {
  // Experts outline the LV alone: that says nothing of the RV.
  const Case& made = small_case();
  LabelCycle lv_only = made.truth;
  for (auto& phase : lv_only.phases) {
    for (std::uint8_t& label : phase) {
      if (label != kLabelLvBlood && label != kLabelLvMyocardium) label = kLabelBackground;
    }
  }
  const int es = end_systole(made);
  const Segmentation result = segmented(made, known_of(lv_only, {0, es}));
  for (std::size_t p = 0; p < result.labels.phases.size(); ++p) {
    EXPECT_GT(dice_of(made, result, Structure::LvBlood, p), 0.92) << p;
    EXPECT_GT(dice_of(made, result, Structure::RvBlood, p), 0.88) << p;
  }
  for (const int p : {0, es}) {
    const auto at = static_cast<std::size_t>(p);
    for (const std::uint8_t label : {kLabelLvBlood, kLabelLvMyocardium}) {
      EXPECT_EQ(made::label_dice(result.labels.phases[at], lv_only.phases[at], label), 1) << p;
    }
  }
}

TEST(KnownLabels, OfThickSlicesEndFlatOnTheSideOfTheBase) {
  phantom::PhantomSpec spec = made::clinical_part();
  spec.anatomy = phantom::ventricles_alone(spec.anatomy);
  const Case made(spec);
  std::vector<int> all(static_cast<std::size_t>(made.truth.phase_count()));
  std::iota(all.begin(), all.end(), 0);
  const Segmentation result = segmented(made, known_of(made.truth, all));
  EXPECT_EQ(result.labels.phases, made.truth.phases);
  ASSERT_EQ(result.valve_planes.count(Structure::LvBlood), 1U);
  const ValvePlane& plane = result.valve_planes.at(Structure::LvBlood);
  EXPECT_EQ(plane.base_step, 1);  // slices run from the apex to the base
  EXPECT_NEAR(plane.k[0], 10.5, 1.0);
}

TEST(KnownLabels, GiveTheSameOnOneThreadAndTwo) {
  phantom::PhantomSpec spec = small_ventricles();
  spec.phases = 4;
  const Case made(spec);
  const KnownLabels known = known_of(made.truth, {0, 2});
  // Against what was given, which stays.
  const std::vector<Seed> seeds{{kLabelRvBlood, made.phantom.spec().anatomy.origin_lps_mm, 5, 2}};
  set_thread_count(1);
  const Segmentation one = segmented(made, known, seeds);
  set_thread_count(2);
  const Segmentation two = segmented(made, known, seeds);
  set_thread_count(0);
  EXPECT_EQ(one.labels.phases[2], made.truth.phases[2]);
  EXPECT_TRUE(std::any_of(one.warnings.begin(), one.warnings.end(), [](const std::string& told) {
    return told.starts_with("seed 1, rv_blood") &&
           told.find("labels that were given there stay") != std::string::npos;
  }));
  EXPECT_EQ(one.warnings, two.warnings);
  EXPECT_EQ(one.labels.phases, two.labels.phases);
  EXPECT_EQ(one.coverage.phases, two.coverage.phases);
}

TEST(KnownLabels, ThatCannotBeUsedAreRefused) {
  const Grid grid = made::straight_grid({10, 10, 4}, {2, 2, 8});
  LabelCycle labels{grid,
                    {std::vector<std::uint8_t>(grid.count(), kLabelLvBlood),
                     std::vector<std::uint8_t>(grid.count(), kLabelBackground)}};
  const auto said = [&](const LabelCycle& cycle, const std::vector<int>& phases) {
    return made::refusal([&] { check_known({cycle, phases}, grid, 5); });
  };
  EXPECT_NE(said(labels, {0, 3}).find("no heart in phase 3"), std::string::npos);
  EXPECT_NE(said(labels, {0, 5}).find("0 to 4"), std::string::npos);
  EXPECT_NE(said(labels, {0}).find("2 images for 1 phases"), std::string::npos);
  EXPECT_NE(said(labels, {3, 3}).find("ascending"), std::string::npos);
  labels.phases[1][0] = 9;
  EXPECT_NE(said(labels, {0, 3}).find("value 9"), std::string::npos);
  labels.grid.size = {10, 4, 10};
  EXPECT_NE(said(labels, {0, 3}).find("grid"), std::string::npos);
}

}  // namespace
}  // namespace beatlas::segment::known_labels_tests
