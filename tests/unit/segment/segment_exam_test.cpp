/// A plain beating ellipsoid: no chambers, oblique to the slices, partial volume and Rician noise.
#include <cmath>

#include <gtest/gtest.h>

#include "pipeline/core/parallel.h"
#include "pipeline/segment/segment.h"
#include "tests/unit/segment/made_images.h"

namespace beatlas::segment {
namespace {

using made::BeatingEllipsoid;

constexpr int kPhases = 5;
/// 700 ml at most, 582 ml at least, as a heart with its cavities; axes oblique to the grid.
BeatingEllipsoid plain() {
  BeatingEllipsoid body;
  body.centre_lps = Vec3(15, -25, 40);
  body.lps_from_axes =
      (Eigen::AngleAxisd(0.6, Vec3::UnitX()) * Eigen::AngleAxisd(-0.5, Vec3::UnitY()) *
       Eigen::AngleAxisd(0.3, Vec3::UnitZ()))
          .toRotationMatrix();
  body.largest_mm = Vec3(48, 53, 65.7);
  body.squeeze = 1 - std::cbrt(582.0 / 700.0);
  return body;
}

Grid plain_grid() { return made::oblique_grid({140, 140, 54}, {1, 1, 3}, Vec3(12, -20, 44)); }

const Exam& plain_exam() {
  static const Exam exam = [] {
    Exam made = made::ellipsoid_exam(plain_grid(), plain(), kPhases, 400, 100);
    made::add_rician_noise(made.stack.images, 20, 5);
    return made;
  }();
  return exam;
}

Segmentation segmented(const Exam& exam, const std::vector<Seed>& seeds = {}) {
  StageContext context;
  return segment_exam(exam, seeds, {}, context);
}

const Segmentation& plain_result() {
  static const Segmentation result = segmented(plain_exam());
  return result;
}

double heart_dice(const Grid& grid, const BeatingEllipsoid& body, const Segmentation& result,
                  int phase) {
  const int n = result.labels.phase_count();
  std::vector<bool> truth;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        truth.push_back(body.contains(grid.mm(i, j, k), phase, n));
      }
    }
  }
  const auto& labels = result.labels.phases[static_cast<std::size_t>(phase)];
  return made::dice(
      grid.count(), [&](std::size_t v) { return truth[v]; },
      [&](std::size_t v) { return labels[v] != kLabelBackground; });
}

TEST(PlainBody, is_found_as_a_heart_without_chambers) {
  const Segmentation& result = plain_result();
  const std::vector<double> curve = volume_curve_ml(result.coverage, Structure::Heart);
  ASSERT_EQ(curve.size(), std::size_t{kPhases});
  for (int p = 0; p < kPhases; ++p) {
    // Threshold growing reaches .998 on this body; .99 is what the project promises at least.
    const double dice = heart_dice(plain_grid(), plain(), result, p);
    EXPECT_GE(dice, 0.99) << p;
    // 2 % of 700 ml is a surface 0.4 mm off everywhere, two fifths of a pixel.
    EXPECT_NEAR(curve[static_cast<std::size_t>(p)] / plain().volume_ml(p, kPhases), 1, 0.02) << p;
    std::cout << "phase " << p << ": Dice " << dice << ", volume "
              << curve[static_cast<std::size_t>(p)] / plain().volume_ml(p, kPhases) << "\n";
  }
  EXPECT_EQ(result.end_diastole, 0);
  // Phases 2 and 3 of 5 are equally empty.
  EXPECT_TRUE(result.end_systole == 2 || result.end_systole == 3);
  ASSERT_EQ(result.warnings.size(), 1U);
  EXPECT_NE(result.warnings[0].find("no left ventricle"), std::string::npos);
  EXPECT_EQ(result.coverage.phases.size(), 1U);
  EXPECT_TRUE(result.base_cuts.empty());
}

TEST(PlainBody, beats_in_the_labels_as_it_does_in_truth) {
  const Segmentation& result = plain_result();
  EXPECT_NE(result.labels.phases[0], result.labels.phases[kPhases / 2]);
}

TEST(PlainBody, is_the_same_on_one_thread_and_two) {
  set_thread_count(1);
  const Segmentation one = segmented(plain_exam());
  set_thread_count(2);
  const Segmentation two = segmented(plain_exam());
  set_thread_count(0);
  EXPECT_EQ(one.labels.phases, two.labels.phases);
  EXPECT_EQ(one.coverage.phases, two.coverage.phases);
}

TEST(PlainBody, grows_from_a_drawn_seed_of_one_phase_too) {
  const Segmentation result =
      segmented(plain_exam(), {{kLabelRestOfHeart, plain().centre_lps, 8, 0}});
  for (int p = 0; p < kPhases; ++p) {
    EXPECT_GE(heart_dice(plain_grid(), plain(), result, p), 0.98) << p;
  }
}

TEST(Refusal, of_images_that_do_not_beat) {
  BeatingEllipsoid still = plain();
  still.squeeze = 0;
  for (int phases : {2, 5}) {
    Exam exam = made::ellipsoid_exam(plain_grid(), still, phases, 400, 100);
    made::add_rician_noise(exam.stack.images, 20, 6);
    const std::string said = made::refusal([&] { (void)segmented(exam); });
    EXPECT_NE(said.find("no heart found"), std::string::npos) << said;
  }
}

TEST(Refusal, of_still_images_in_air_whose_noise_is_rician) {
  BeatingEllipsoid still = plain();
  still.squeeze = 0;
  for (int phases : {2, 5, 15}) {
    Exam exam = made::ellipsoid_exam(made::oblique_grid({96, 96, 40}, {2, 2, 4}, {12, -20, 44}),
                                     still, phases, 400, 0);
    made::add_rician_noise(exam.stack.images, 20, 6);
    const std::string said = made::refusal([&] { (void)segmented(exam); });
    EXPECT_NE(said.find("no heart found"), std::string::npos) << said;
  }
}

TEST(Refusal, of_a_single_phase) {
  const Exam exam = made::ellipsoid_exam(plain_grid(), plain(), 1, 400, 100);
  const std::string said = made::refusal([&] { (void)segmented(exam); });
  EXPECT_NE(said.find("one phase"), std::string::npos) << said;
}

TEST(Refusal, of_constant_images) {
  Exam exam = made::ellipsoid_exam(made::straight_grid({32, 32, 8}, {2, 2, 6}), plain(), 4, 0, 0);
  for (float value : {0.0F, 4095.0F}) {
    exam.stack.images = made::constant_images(exam.stack.images.grid, 4, value);
    const std::string said = made::refusal([&] { (void)segmented(exam); });
    EXPECT_NE(said.find("no heart found"), std::string::npos) << said;
  }
}

TEST(Cancel, stops_the_segmentation) {
  const std::atomic<bool> stop{true};
  StageContext context;
  context.cancel = &stop;
  EXPECT_THROW((void)segment_exam(plain_exam(), {}, {}, context), Error);
}

}  // namespace
}  // namespace beatlas::segment
