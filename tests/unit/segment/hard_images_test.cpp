/// Images that are hard on the numerics: none may crash, hang or give what is no segmentation.
#include <algorithm>
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "pipeline/segment/alarm.h"
#include "pipeline/segment/segment.h"
#include "tests/unit/segment/made_images.h"

namespace beatlas::segment {
namespace {

using made::BeatingEllipsoid;

BeatingEllipsoid ball_at(const Vec3& centre, double radius_mm) {
  BeatingEllipsoid ball;
  ball.centre_lps = centre;
  ball.largest_mm = Vec3::Constant(radius_mm);
  ball.squeeze = 0.15;
  return ball;
}

double heart_dice(const Segmentation& result, const BeatingEllipsoid& body, int phase) {
  const Grid& grid = result.labels.grid;
  std::vector<bool> truth;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        truth.push_back(body.contains(grid.mm(i, j, k), phase, result.labels.phase_count()));
      }
    }
  }
  const auto& labels = result.labels.phases[static_cast<std::size_t>(phase)];
  return made::dice(
      truth.size(), [&](std::size_t v) { return truth[v]; },
      [&](std::size_t v) { return labels[v] != 0; });
}

void expect_sound(const Segmentation& result) {
  for (const auto& [structure, phases] : result.coverage.phases) {
    for (const auto& phase : phases) {
      for (float c : phase) ASSERT_TRUE(c >= 0 && c <= 1) << structure_name(structure);
    }
  }
  for (const auto& phase : result.labels.phases) {
    for (std::uint8_t label : phase) ASSERT_LE(label, kLabelRestOfHeart);
  }
}

Segmentation segmented(const Exam& exam, const std::vector<Seed>& seeds = {}) {
  StageContext context;
  return segment_exam(exam, seeds, {}, context);
}

const Grid kGrid = made::straight_grid({56, 56, 30}, {2, 2, 3});
const BeatingEllipsoid kBall = ball_at(Vec3(55, 55, 43), 32);

TEST(HardImages, the_full_range_of_sixteen_bits_is_as_good_as_any) {
  Exam exam = made::ellipsoid_exam(kGrid, kBall, 4, 65535, 0);
  const Segmentation result = segmented(exam);
  expect_sound(result);
  for (int p = 0; p < 4; ++p) EXPECT_GE(heart_dice(result, kBall, p), 0.96) << p;
}

TEST(HardImages, two_phases_are_enough) {
  Exam exam = made::ellipsoid_exam(kGrid, kBall, 2, 400, 100);
  made::add_rician_noise(exam.stack.images, 15, 1);
  const Segmentation result = segmented(exam);
  expect_sound(result);
  for (int p = 0; p < 2; ++p) EXPECT_GE(heart_dice(result, kBall, p), 0.96) << p;
}

TEST(HardImages, voxels_twenty_times_as_long_as_wide_are_taken) {
  const BeatingEllipsoid ball = ball_at(Vec3(55, 55, 60), 45);
  Exam exam =
      made::ellipsoid_exam(made::straight_grid({110, 110, 7}, {1, 1, 20}), ball, 3, 400, 100);
  made::add_rician_noise(exam.stack.images, 15, 2);
  const Segmentation result = segmented(exam);
  expect_sound(result);
  // The slices at both poles are mixed throughout, so how wide the body is there cannot be told:
  // two of five sections may be twice as large. The three between are right.
  for (int p = 0; p < 3; ++p) EXPECT_GE(heart_dice(result, ball, p), 0.8) << p;
  const Grid& grid = result.labels.grid;
  for (int k : {2, 3, 4}) {
    const auto from =
        result.labels.phases[0].begin() + static_cast<std::ptrdiff_t>(grid.offset(0, 0, k));
    const auto area = static_cast<double>(
        grid.slice_count() -
        static_cast<std::size_t>(std::count(
            from, from + static_cast<std::ptrdiff_t>(grid.slice_count()), kLabelBackground)));
    // The section half-way through the slice; mixed pixels at its rim may fall to either side.
    const double z = 20.0 * k - 60;
    EXPECT_NEAR(area / (M_PI * (45 * 45 - z * z)), 1, 0.17) << k;
  }
}

TEST(HardImages, a_heart_cut_by_the_field_of_view_is_kept_inside_it) {
  for (const Vec3& centre : {Vec3(55, 55, 12), Vec3(14, 55, 43)}) {
    const BeatingEllipsoid ball = ball_at(centre, 32);
    Exam exam = made::ellipsoid_exam(kGrid, ball, 4, 400, 100);
    made::add_rician_noise(exam.stack.images, 10, 3);
    const Segmentation result = segmented(exam);
    expect_sound(result);
    // The image's rim is background by definition, 2 of 46 mm.
    for (int p = 0; p < 4; ++p) EXPECT_GE(heart_dice(result, ball, p), 0.9) << p;
  }
}

TEST(HardImages, of_two_seeds_in_one_voxel_the_later_counts) {
  Exam exam = made::ellipsoid_exam(kGrid, kBall, 3, 400, 100);
  made::add_rician_noise(exam.stack.images, 15, 4);
  const Segmentation result = segmented(exam, {{kLabelLvBlood, kBall.centre_lps, 4, -1},
                                               {kLabelRestOfHeart, kBall.centre_lps, 4, -1}});
  expect_sound(result);
  const auto at = kGrid.mm_from_index.inverse() * kBall.centre_lps;
  EXPECT_EQ(result.labels.phases[0][kGrid.offset(static_cast<int>(std::lround(at[0])),
                                                 static_cast<int>(std::lround(at[1])),
                                                 static_cast<int>(std::lround(at[2])))],
            kLabelRestOfHeart);
}

TEST(HardImages, muscle_drawn_on_tissue_as_bright_as_blood_is_refused) {
  // The travel costs divide by the contrast of the two.
  const Exam exam = made::ellipsoid_exam(kGrid, kBall, 3, 400, 100);
  const std::string said = made::refusal([&] {
    (void)segmented(exam, {{kLabelLvBlood, kBall.centre_lps + Vec3(10, 0, 0), 4, -1},
                           {kLabelLvMyocardium, kBall.centre_lps - Vec3(10, 0, 0), 4, -1}});
  });
  EXPECT_NE(said.find("seeds of muscle"), std::string::npos) << said;
}

TEST(HardImages, a_single_slice_is_taken) {
  const BeatingEllipsoid ball = ball_at(Vec3(55, 55, 0), 32);
  Exam exam = made::ellipsoid_exam(made::straight_grid({56, 56, 1}, {2, 2, 8}), ball, 4, 400, 100);
  made::add_rician_noise(exam.stack.images, 15, 5);
  const Segmentation result = segmented(exam);
  expect_sound(result);
  for (int p = 0; p < 4; ++p) EXPECT_GE(heart_dice(result, ball, p), 0.95) << p;
}

TEST(HardImages, the_range_of_signed_sixteen_bits_is_as_good_as_any) {
  Exam exam = made::ellipsoid_exam(kGrid, kBall, 4, 32767, -32768);
  const Segmentation result = segmented(exam);
  expect_sound(result);
  for (int p = 0; p < 4; ++p) EXPECT_GE(heart_dice(result, kBall, p), 0.96) << p;
}

/// Runs `change` for every voxel of every phase.
void change_images(Exam& exam, const std::function<void(const Vec3& lps, float& value)>& change) {
  const Grid& grid = exam.stack.grid();
  for (std::vector<float>& phase : exam.stack.images.phases) {
    std::size_t v = 0;
    for (int k = 0; k < grid.size[2]; ++k) {
      for (int j = 0; j < grid.size[1]; ++j) {
        for (int i = 0; i < grid.size[0]; ++i, ++v) change(grid.mm(i, j, k), phase[v]);
      }
    }
  }
}

TEST(HardImages, against_a_still_body_as_bright_the_alarm_rings_and_seeds_help) {
  // 3 mm of the ball's largest extent lie in it: no edge tells where the ball ends there.
  constexpr double kFace = 84;
  Exam exam = made::ellipsoid_exam(kGrid, kBall, 6, 400, 100);
  change_images(exam, [](const Vec3& lps, float& value) {
    if (lps[1] > kFace) value = 400;
  });
  made::add_rician_noise(exam.stack.images, 15, 6);
  const Segmentation result = segmented(exam);
  expect_sound(result);
  for (int p = 0; p < 6; ++p) EXPECT_GE(heart_dice(result, kBall, p), 0.75) << p;
  StageContext context;
  const std::vector<LeakAlarm> alarms = leak_alarms(exam.stack, result, {}, context);
  const auto bare = std::find_if(alarms.begin(), alarms.end(), [](const LeakAlarm& alarm) {
    return alarm.kind == LeakKind::NoEdge;
  });
  ASSERT_NE(bare, alarms.end());
  EXPECT_GT(bare->lps_mm[1], kFace - 6);

  const Segmentation helped = segmented(exam, {{kLabelBackground, Vec3(55, 98, 43), 9, -1},
                                               {kLabelBackground, Vec3(30, 98, 43), 9, -1},
                                               {kLabelBackground, Vec3(80, 98, 43), 9, -1},
                                               {kLabelRestOfHeart, kBall.centre_lps, 20, -1}});
  expect_sound(helped);
  // Where no edge is, three balls of background do not draw a face.
  for (int p = 0; p < 6; ++p) {
    EXPECT_GE(heart_dice(helped, kBall, p), 0.87) << p;
    EXPECT_GT(heart_dice(helped, kBall, p), heart_dice(result, kBall, p)) << p;
  }
}

TEST(HardImages, pools_parted_by_a_wall_of_one_voxel_are_one_heart) {
  Exam exam = made::ellipsoid_exam(kGrid, kBall, 6, 400, 100);
  change_images(exam, [](const Vec3& lps, float& value) {
    if (std::abs(lps[0] - 56) < 0.5) value = std::min(value, 150.0F);  // one column of voxels
  });
  made::add_rician_noise(exam.stack.images, 15, 7);
  const Segmentation result = segmented(exam);
  expect_sound(result);
  for (int p = 0; p < 6; ++p) EXPECT_GE(heart_dice(result, kBall, p), 0.9) << p;
}

TEST(HardImages, a_hundred_phases_are_taken) {
  const BeatingEllipsoid ball = ball_at(Vec3(47, 47, 30), 26);
  Exam exam =
      made::ellipsoid_exam(made::straight_grid({32, 32, 16}, {3, 3, 4}), ball, 100, 400, 100);
  made::add_rician_noise(exam.stack.images, 15, 8);
  const Segmentation result = segmented(exam);
  expect_sound(result);
  ASSERT_EQ(result.labels.phase_count(), 100);
  // Voxels of 3 x 3 x 4 mm: a quarter of the body's lie on its surface.
  for (int p = 0; p < 100; p += 9) EXPECT_GE(heart_dice(result, ball, p), 0.9) << p;
}

TEST(HardImages, constant_images_are_refused_though_seeds_were_drawn) {
  Exam exam;
  exam.stack.images = made::constant_images(kGrid, 3, 200);
  const std::string said = made::refusal([&] {
    (void)segmented(exam, {{kLabelLvBlood, kBall.centre_lps, 4, -1},
                           {kLabelBackground, Vec3(10, 10, 10), 4, -1}});
  });
  EXPECT_NE(said.find("no heart found"), std::string::npos) << said;
}

}  // namespace
}  // namespace beatlas::segment
