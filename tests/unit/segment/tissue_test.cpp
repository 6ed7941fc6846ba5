#include "pipeline/segment/tissue.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "tests/unit/segment/made_images.h"

namespace beatlas::segment {
namespace {

using made::BeatingEllipsoid;

TEST(Noise, of_static_images_is_the_known_one) {
  for (int phases : {2, 3, 15}) {
    auto images = made::constant_images(made::straight_grid({40, 40, 16}, {1, 1, 3}), phases, 500);
    made::add_noise(images, 20, 7);
    // A median of 25600 voxels tells a standard deviation to 0.8 % (one standard error).
    EXPECT_NEAR(temporal_stats(images).noise, 20, 20 * 0.032) << phases;
  }
}

TEST(Noise, is_not_hidden_by_voxels_that_are_zero_in_every_phase) {
  for (int phases : {2, 15}) {
    auto images = made::constant_images(made::straight_grid({40, 40, 16}, {1, 1, 3}), phases, 500);
    made::add_noise(images, 20, 8);
    for (auto& phase : images.phases) {  // masked air: two thirds of the image
      for (std::size_t v = 0; v < phase.size(); ++v) phase[v] = v % 3 == 0 ? phase[v] : 0;
    }
    EXPECT_NEAR(temporal_stats(images).noise, 20, 20 * 0.055) << phases;  // a third of the voxels
  }
}

TEST(Noise, is_that_of_tissue_where_most_of_a_magnitude_image_is_air) {
  for (int phases : {2, 15}) {
    auto images = made::constant_images(made::straight_grid({40, 40, 16}, {1, 1, 3}), phases, 0);
    for (auto& phase : images.phases) {
      for (std::size_t v = 0; v < phase.size(); v += 4) phase[v] = 400;
    }
    made::add_rician_noise(images, 20, 10);
    EXPECT_NEAR(temporal_stats(images).noise, 20, 20 * 0.064) << phases;  // a quarter of the voxels
  }
}

TEST(Noise, of_constant_images_is_none) {
  const auto images = made::constant_images(made::straight_grid({8, 8, 4}, {1, 1, 3}), 5, 500);
  const TemporalStats stats = temporal_stats(images);
  EXPECT_EQ(stats.noise, 0);
  // Sums of squares in double precision cancel to 1e-16 of 500^2.
  for (float swing : stats.swing) EXPECT_NEAR(swing, 0, 1e-4);
}

TEST(Swing, of_a_sine_is_its_amplitude_over_the_root_of_two) {
  constexpr int kPhases = 15;
  constexpr double kAmplitude = 50;
  auto images = made::constant_images(made::straight_grid({40, 40, 16}, {1.5, 1.5, 3}), kPhases, 0);
  const auto sine = [](int p) {
    return 500 + kAmplitude * std::sin(2 * std::numbers::pi * p / kPhases);
  };
  double low = 1e9;
  double high = 0;
  for (int p = 0; p < kPhases; ++p) {
    std::fill(images.phases[p].begin(), images.phases[p].end(), static_cast<float>(sine(p)));
    low = std::min(low, sine(p));
    high = std::max(high, sine(p));
  }
  const TemporalStats still = temporal_stats(images);
  // Noise takes a slow sine's second difference for its own: amplitude (1 - cos(2 pi / 15)) at
  // most. That may take 1 % off the swing.
  for (std::size_t v : {std::size_t{0}, images.grid.count() / 2}) {
    EXPECT_NEAR(still.swing[v], kAmplitude / std::numbers::sqrt2, 0.01 * kAmplitude);
    EXPECT_NEAR(still.mean[v], 500, 1e-3);
    EXPECT_NEAR(still.low[v], low, 1e-3);
    EXPECT_NEAR(still.high[v], high, 1e-3);
  }
  made::add_noise(images, 20, 9);
  const TemporalStats noisy = temporal_stats(images);
  double square = 0;
  for (float swing : noisy.swing)
    square += swing * swing / static_cast<double>(images.grid.count());
  // 25600 voxels average the rest of the noise out; 1 % as before.
  EXPECT_NEAR(std::sqrt(square), kAmplitude / std::numbers::sqrt2, 0.01 * kAmplitude);
}

TEST(SmoothInPlane, keeps_the_mean_and_one_slice_from_the_next) {
  const Grid grid = made::straight_grid({31, 31, 3}, {1, 2, 5});
  std::vector<float> image(grid.count(), 0);
  image[grid.offset(15, 15, 1)] = 1;
  const std::vector<float> smooth = smooth_in_plane(grid, image, 3.0);
  double sum = 0;
  double xx = 0;
  double yy = 0;
  for (int j = 0; j < 31; ++j) {
    for (int i = 0; i < 31; ++i) {
      EXPECT_EQ(smooth[grid.offset(i, j, 0)], 0);
      EXPECT_EQ(smooth[grid.offset(i, j, 2)], 0);
      const double w = smooth[grid.offset(i, j, 1)];
      sum += w;
      xx += w * (i - 15) * (i - 15);
      yy += w * 4 * (j - 15) * (j - 15);
    }
  }
  EXPECT_NEAR(sum, 1, 1e-5);
  // 3 mm along both axes whatever the pixel; a kernel of 3 to 4 sigma loses 3 % of the variance.
  EXPECT_NEAR(std::sqrt(xx), 3, 0.05);
  EXPECT_NEAR(std::sqrt(yy), 3, 0.05);
  EXPECT_EQ(smooth_in_plane(grid, image, 0), image);
}

TEST(MovingBox, holds_a_beating_ball_and_not_much_more) {
  const Grid grid = made::straight_grid({100, 90, 40}, {2, 2, 4});
  BeatingEllipsoid ball;
  ball.centre_lps = grid.mm(38, 50, 18);
  ball.largest_mm = Vec3::Constant(30);
  ball.squeeze = 0.2;
  Exam exam = made::ellipsoid_exam(grid, ball, 10, 400, 100);
  made::add_noise(exam.stack.images, 15, 3);
  const Box box = find_moving_box(grid, temporal_stats(exam.stack.images));
  for (int a = 0; a < 3; ++a) {
    const double spacing = grid.spacing_mm()[a];
    const double low_mm = (box.first[a] - 0.5) * spacing;
    const double high_mm = low_mm + box.size[a] * spacing;
    EXPECT_LT(low_mm, ball.centre_lps[a] - 30) << a;
    EXPECT_GT(high_mm, ball.centre_lps[a] + 30) << a;
    // The margin is 20 mm, a voxel more by rounding.
    EXPECT_GT(low_mm, ball.centre_lps[a] - 30 - 20 - 2 * spacing) << a;
    EXPECT_LT(high_mm, ball.centre_lps[a] + 30 + 20 + 2 * spacing) << a;
  }
}

TEST(MovingBox, refuses_images_that_are_still_but_for_noise) {
  for (int phases : {2, 3, 5, 15, 40}) {
    auto images = made::constant_images(made::straight_grid({60, 60, 12}, {2, 2, 4}), phases, 300);
    made::add_noise(images, 25, static_cast<unsigned>(phases));
    const std::string said =
        made::refusal([&] { (void)find_moving_box(images.grid, temporal_stats(images)); });
    EXPECT_NE(said.find("no heart found"), std::string::npos) << phases << ": " << said;
  }
}

TEST(MovingBox, refuses_constant_images) {
  for (float value : {0.0F, 700.0F}) {
    const auto images = made::constant_images(made::straight_grid({9, 9, 3}, {2, 2, 4}), 4, value);
    (void)made::refusal([&] { (void)find_moving_box(images.grid, temporal_stats(images)); });
  }
}

TEST(Crop, keeps_every_voxel_where_it_is_in_the_patient) {
  const Grid grid = made::oblique_grid({9, 8, 7}, {1, 2, 3}, {10, -20, 30});
  ImageCycle<float> images = made::constant_images(grid, 2, 0);
  for (auto& phase : images.phases) {
    for (std::size_t v = 0; v < phase.size(); ++v) phase[v] = static_cast<float>(v);
  }
  const Box box{{2, 3, 1}, {4, 3, 5}};
  const ImageCycle<float> part = crop(images, box);
  EXPECT_EQ(part.grid.size, box.size);
  for (int k = 0; k < 5; ++k) {
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 4; ++i) {
        EXPECT_EQ(part.phases[1][part.grid.offset(i, j, k)],
                  images.phases[1][grid.offset(i + 2, j + 3, k + 1)]);
        EXPECT_LT((part.grid.mm(i, j, k) - grid.mm(i + 2, j + 3, k + 1)).norm(), 1e-9);
      }
    }
  }
}

TEST(Otsu, parts_two_clusters_in_the_middle_of_their_gap) {
  std::vector<float> values;
  for (int n = 0; n < 300; ++n) values.push_back(static_cast<float>(90 + n % 21));   // 90..110
  for (int n = 0; n < 700; ++n) values.push_back(static_cast<float>(290 + n % 21));  // 290..310
  EXPECT_NEAR(otsu_threshold(values), 200, 1e-3);
}

TEST(Otsu, minimises_the_variance_inside_the_classes) {
  std::mt19937 random(21);
  std::normal_distribution<float> low(100, 30);
  std::normal_distribution<float> high(220, 40);
  std::vector<float> values;  // fewer than 200: no end is clipped
  for (int n = 0; n < 180; ++n) values.push_back(n % 3 == 0 ? low(random) : high(random));
  const auto inner = [&](double threshold) {
    double sum = 0;
    for (bool above : {false, true}) {
      double mean = 0;
      double count = 0;
      for (float v : values) {
        if ((v > threshold) != above) continue;
        mean += v;
        ++count;
      }
      if (count > 0) mean /= count;
      for (float v : values) {
        if ((v > threshold) == above) sum += (v - mean) * (v - mean);
      }
    }
    return sum;
  };
  double best = 1e30;
  for (float v : values) best = std::min(best, inner(v));
  EXPECT_NEAR(inner(otsu_threshold(values)), best, 1e-6 * best);
}

TEST(Otsu, takes_values_that_are_all_the_same_or_none) {
  EXPECT_EQ(otsu_threshold({}), 0);
  EXPECT_EQ(otsu_threshold({5, 5, 5}), 5);
  EXPECT_EQ(otsu_threshold({5}), 5);
}

}  // namespace
}  // namespace beatlas::segment
