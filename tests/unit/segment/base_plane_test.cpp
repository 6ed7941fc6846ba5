/// The base plane from what basal slices mix, on images whose plane is known.
#include "pipeline/segment/base_plane.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/unit/segment/made_images.h"

namespace beatlas::segment {
namespace {

constexpr double kBlood = 1000;
constexpr double kMuscle = 300;
constexpr double kLung = 50;
constexpr int kSlices = 10;
constexpr int kPhases = 12;

/// A round ventricle of muscle and blood up to a plane, a smaller pool beyond it, in slices that
/// average over their whole thickness. Base towards larger k, or smaller if `upside_down`.
struct Tube {
  ImageCycle<float> images;
  ImageCycle<std::uint8_t> labels;
  std::vector<double> plane_k;
};

Tube tube(bool upside_down, double top_k) {
  Tube out;
  const Grid grid = made::straight_grid({64, 64, kSlices}, {1.5, 1.5, 10});
  out.images = made::constant_images(grid, kPhases, 0);
  out.labels.grid = grid;
  out.labels.phases.assign(kPhases, std::vector<std::uint8_t>(grid.count(), kLabelBackground));
  for (int p = 0; p < kPhases; ++p) {
    const double plane = top_k - 0.7 * (1 - std::cos(2 * std::numbers::pi * p / kPhases));
    out.plane_k.push_back(upside_down ? kSlices - 1 - plane : plane);
    for (int k = 0; k < kSlices; ++k) {
      const double height = upside_down ? kSlices - 1 - k : k;
      const double share = std::clamp(plane - height + 0.5, 0.0, 1.0);
      for (int j = 0; j < 64; ++j) {
        for (int i = 0; i < 64; ++i) {
          const double r = 1.5 * std::hypot(i - 32, j - 32);
          const double below = r < 20 ? kBlood : r < 30 ? kMuscle : kLung;
          const double above = 1.5 * std::hypot(i - 28, j - 32) < 14 ? kBlood : kLung;
          const std::size_t v = grid.offset(i, j, k);
          out.images.phases[static_cast<std::size_t>(p)][v] =
              static_cast<float>(share * below + (1 - share) * above);
          // As growing leaves it: the ventricle's labels go on beyond the plane.
          out.labels.phases[static_cast<std::size_t>(p)][v] = r < 20   ? kLabelLvBlood
                                                              : r < 30 ? kLabelLvMyocardium
                                                                       : kLabelBackground;
        }
      }
    }
  }
  made::add_noise(out.images, 50, 3);
  return out;
}

std::optional<std::vector<double>> found(const Tube& made, int step) {
  return base_plane_by_mixture(
      {made.images, made.labels, 4, step, kBlood - kMuscle, 0.5 * (kBlood + kMuscle)},
      {kLabelLvBlood, kLabelLvMyocardium}, false);
}

TEST(BasePlane, is_found_within_slices_to_two_millimetres) {
  for (const bool upside_down : {false, true}) {
    const Tube made = tube(upside_down, 7.3);
    const auto planes = found(made, upside_down ? -1 : 1);
    ASSERT_TRUE(planes);
    for (std::size_t p = 0; p < planes->size(); ++p) {
      EXPECT_NEAR((*planes)[p], made.plane_k[p], 0.2) << p << upside_down;
    }
  }
}

TEST(BasePlane, of_a_ventricle_that_narrows_to_its_base_is_where_most_changes) {
  Tube made = tube(false, 7.3);
  const Grid& grid = made.images.grid;
  constexpr double kFat = 1250;
  for (std::size_t p = 0; p < made.images.phases.size(); ++p) {
    for (int k = 0; k < kSlices; ++k) {
      const double share = std::clamp(made.plane_k[p] - k + 0.5, 0.0, 1.0);
      const double wide = 1 - 0.02 * std::max(0, k - 5) * std::max(0, k - 5);
      for (int j = 0; j < 64; ++j) {
        for (int i = 0; i < 64; ++i) {
          const double r = 1.5 * std::hypot(i - 32, j - 32) / wide;
          const double below = r < 20 ? kBlood : r < 30 ? kMuscle : r < 40 ? kFat : kLung;
          const double above = 1.5 * std::hypot(i - 28, j - 32) < 14 ? kBlood : kLung;
          const std::size_t v = grid.offset(i, j, k);
          made.images.phases[p][v] = static_cast<float>(share * below + (1 - share) * above);
          made.labels.phases[p][v] = r < 20   ? kLabelLvBlood
                                     : r < 30 ? kLabelLvMyocardium
                                              : kLabelBackground;
        }
      }
    }
  }
  made::add_noise(made.images, 50, 3);
  const auto planes = found(made, 1);
  ASSERT_TRUE(planes);
  for (std::size_t p = 0; p < planes->size(); ++p) {
    EXPECT_NEAR((*planes)[p], made.plane_k[p], 0.4) << p;
  }
}

TEST(BasePlane, of_a_cavity_is_not_where_its_trabeculae_end) {
  Tube made = tube(false, 7.3);
  const Grid& grid = made.images.grid;
  for (std::size_t p = 0; p < made.images.phases.size(); ++p) {
    for (std::size_t v = 0; v < grid.count(); ++v) {
      if (made.labels.phases[p][v] != kLabelLvBlood) {
        made.labels.phases[p][v] = kLabelBackground;
        continue;
      }
      made.labels.phases[p][v] = kLabelRvBlood;
      const auto k = static_cast<int>(v / grid.slice_count());
      if (k <= 4 && v % 3 == 0) made.images.phases[p][v] = static_cast<float>(kMuscle);
    }
  }
  const auto planes = base_plane_by_mixture(
      {made.images, made.labels, 4, 1, kBlood - kMuscle, 0.5 * (kBlood + kMuscle)}, {kLabelRvBlood},
      true);
  ASSERT_TRUE(planes);
  for (std::size_t p = 0; p < planes->size(); ++p) {
    EXPECT_NEAR((*planes)[p], made.plane_k[p], 0.3) << p;
  }
}

TEST(BasePlane, of_a_ventricle_under_fat_is_not_the_upper_side_of_the_fat) {
  constexpr double kFat = 1250;
  constexpr double kFatMm = 4;
  Tube made = tube(false, 7.3);
  const Grid& grid = made.images.grid;
  for (std::size_t p = 0; p < made.images.phases.size(); ++p) {
    for (int k = 0; k < kSlices; ++k) {
      const double share = std::clamp(made.plane_k[p] - k + 0.5, 0.0, 1.0);
      const double with_fat = std::clamp(made.plane_k[p] + kFatMm / 10 - k + 0.5, 0.0, 1.0);
      for (int j = 0; j < 64; ++j) {
        for (int i = 0; i < 64; ++i) {
          const double r = 1.5 * std::hypot(i - 32, j - 32);
          if (r >= 30 + kFatMm) continue;
          const std::size_t v = grid.offset(i, j, k);
          const double below = r < 30 ? kBlood : kFat;
          made.images.phases[p][v] = static_cast<float>(share * below + (with_fat - share) * kFat +
                                                        (1 - with_fat) * kLung);
          made.labels.phases[p][v] = r < 30 ? kLabelRvBlood : kLabelBackground;
        }
      }
    }
  }
  made::add_noise(made.images, 50, 3);
  const auto planes = base_plane_by_mixture(
      {made.images, made.labels, 4, 1, kBlood - kMuscle, 0.5 * (kBlood + kMuscle)}, {kLabelRvBlood},
      true);
  ASSERT_TRUE(planes);
  for (std::size_t p = 0; p < planes->size(); ++p) {
    EXPECT_NEAR((*planes)[p], made.plane_k[p], 0.25) << p;  // the fat is 0.4 of a slice
  }
}

TEST(BasePlane, beyond_the_stack_is_told_by_no_slice) { EXPECT_FALSE(found(tube(false, 12), 1)); }

TEST(BasePlane, is_not_told_by_slices_that_are_no_mixture) {
  Tube made = tube(false, 7.3);
  // Beyond the middle every slice is a picture of its own.
  unsigned state = 7;
  const Grid& grid = made.images.grid;
  for (std::vector<float>& image : made.images.phases) {
    for (std::size_t v = grid.offset(0, 0, 4); v < image.size(); ++v) {
      state = state * 1664525U + 1013904223U;
      image[v] = static_cast<float>(state >> 22);
    }
  }
  EXPECT_FALSE(found(made, 1));
}

}  // namespace
}  // namespace beatlas::segment
