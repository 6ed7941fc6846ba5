/// Fat on the wall of a made heart of concentric spheres.
#include "pipeline/segment/outer_layer.h"

#include <gtest/gtest.h>

#include "pipeline/segment/segment.h"
#include "tests/unit/segment/made_images.h"

namespace beatlas::segment {
namespace {

constexpr double kCavityMm = 20;
constexpr double kWallMm = 29;
constexpr float kBlood = 1000;
constexpr float kMuscle = 600;
constexpr float kLung = 40;

enum Tissue : std::uint8_t { kIsLung, kIsBlood, kIsMuscle, kIsFat };

/// A cavity in a wall, with fat on one half of it. What is no lung is labelled wall.
struct Made {
  Grid grid = made::straight_grid({80, 80, 24}, {1, 1, 3});
  ImageCycle<float> images = made::constant_images(grid, 2, kLung);
  ImageCycle<std::uint8_t> labels;
  std::vector<Tissue> tissue;
  Chambers chambers;

  /// @param fat_side where it is thickest
  Made(float fat, double fat_mm, double noise, const Vec3& fat_side = Vec3::UnitX())
      : labels{grid, {}}, tissue(grid.count(), kIsLung) {
    labels.phases.assign(2, std::vector<std::uint8_t>(grid.count(), kLabelBackground));
    const Vec3 middle = grid.mm_from_index * Vec3(39.5, 39.5, 11.5);
    std::size_t v = 0;
    for (int k = 0; k < 24; ++k) {
      for (int j = 0; j < 80; ++j) {
        for (int i = 0; i < 80; ++i, ++v) {
          const Vec3 at = grid.mm_from_index * Vec3(i, j, k) - middle;
          const double r = at.norm();
          // Thicker toward the middle of its half, as fat is.
          const double out = kWallMm + fat_mm * std::max(0.0, at.dot(fat_side) / std::max(r, 1.0));
          tissue[v] = r < kCavityMm ? kIsBlood
                      : r < kWallMm ? kIsMuscle
                      : r < out     ? kIsFat
                                    : kIsLung;
          if (tissue[v] == kIsLung) continue;
          for (std::size_t p = 0; p < 2; ++p) {
            labels.phases[p][v] = tissue[v] == kIsBlood ? kLabelLvBlood : kLabelLvMyocardium;
            images.phases[p][v] = tissue[v] == kIsBlood ? kBlood
                                  : tissue[v] == kIsFat ? fat
                                                        : kMuscle;
          }
        }
      }
    }
    made::add_noise(images, noise, 7);
    chambers.levels.blood = kBlood;
    chambers.levels.rv_blood = kBlood;
    chambers.levels.muscle = kMuscle;
    chambers.levels.threshold = 0.5 * (kBlood + kMuscle);
    chambers.levels.dark = 0.5 * kMuscle;
    chambers.lv.resize(1);
  }

  /// @param from the first slice that counts
  [[nodiscard]] double share_kept(Tissue of, int from = 0) const {
    double all = 0;
    double kept = 0;
    for (std::size_t v = grid.offset(0, 0, from); v < tissue.size(); ++v) {
      if (tissue[v] != of) continue;
      all += 1;
      kept += labels.phases[1][v] != kLabelBackground ? 1 : 0;
    }
    return all > 0 ? kept / all : 0;
  }
};

TEST(OuterLayer, of_fat_hardly_brighter_than_muscle_comes_off) {
  constexpr double kNoise = 100;  // two thirds of the step from muscle to fat
  Made heart(750, 6, kNoise);
  strip_outer_layer(heart.images, kNoise, heart.chambers, heart.labels);
  EXPECT_LT(heart.share_kept(kIsFat), 0.25) << "its thin rim cannot be told";
  EXPECT_GT(heart.share_kept(kIsMuscle), 0.985);
  EXPECT_EQ(heart.share_kept(kIsBlood), 1);
}

TEST(OuterLayer, of_bright_fat_comes_off) {
  Made heart(1300, 6, 20);
  strip_outer_layer(heart.images, 20, heart.chambers, heart.labels);
  EXPECT_LT(heart.share_kept(kIsFat), 0.25);
  EXPECT_GT(heart.share_kept(kIsMuscle), 0.985);
}

TEST(OuterLayer, beyond_the_last_slice_of_the_cavity_ends_as_before_it) {
  constexpr double kNoise = 100;
  Made heart(750, 8, kNoise, Vec3(1, 0, 1).normalized());
  // There the muscle went to what stands on the ventricle: fat alone is left, and no step shows.
  const int beyond = static_cast<int>(11.5 + kCavityMm / 3) + 1;
  for (auto& phase : heart.labels.phases) {
    for (std::size_t v = heart.grid.offset(0, 0, beyond); v < phase.size(); ++v) {
      if (heart.tissue[v] == kIsMuscle) phase[v] = kLabelBackground;
    }
  }
  strip_outer_layer(heart.images, kNoise, heart.chambers, heart.labels);
  EXPECT_LT(heart.share_kept(kIsFat, beyond), 0.1);
}

TEST(OuterLayer, is_none_where_there_is_muscle_alone) {
  for (const double noise : {0.0, 50.0, 100.0, 200.0}) {
    Made heart(kMuscle, 6, noise);
    const std::vector<std::vector<std::uint8_t>> before = heart.labels.phases;
    strip_outer_layer(heart.images, noise, heart.chambers, heart.labels);
    EXPECT_EQ(heart.labels.phases, before) << "noise " << noise;
  }
}

TEST(OuterLayer, stays_where_the_wall_is_shared_with_the_right_ventricle) {
  Made heart(750, 6, 20);
  for (auto& phase : heart.labels.phases) {
    for (std::size_t v = 0; v < phase.size(); ++v) {
      if (heart.tissue[v] == kIsLung) phase[v] = kLabelRvBlood;
    }
  }
  const std::vector<std::vector<std::uint8_t>> before = heart.labels.phases;
  strip_outer_layer(heart.images, 20, heart.chambers, heart.labels);
  for (std::size_t v = 0; v < before[0].size(); ++v) {
    if (before[0][v] == kLabelLvMyocardium) continue;
    EXPECT_EQ(heart.labels.phases[0][v], before[0][v]);
  }
  EXPECT_GT(heart.share_kept(kIsMuscle), 0.985);
}

}  // namespace
}  // namespace beatlas::segment
