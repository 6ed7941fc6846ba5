/// A made heart: an LV in its ring, an RV beside it, both tubes along the slices' normal.
#include "pipeline/segment/anatomy.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/unit/segment/made_images.h"

namespace beatlas::segment {
namespace {

constexpr float kBlood = 1000;
constexpr float kMuscle = 600;
constexpr float kLiver = 820;  // noise and shading have lifted it past the threshold
constexpr float kLung = 40;

struct Made {
  Grid grid;
  std::vector<float> image;
  std::vector<std::uint8_t> labels;
  std::vector<std::uint8_t> drawn;
  std::vector<std::uint8_t> in_liver;
  Chambers chambers;

  explicit Made(double slice_mm) : grid(made::straight_grid({120, 80, 16}, {1, 1, slice_mm})) {
    image.assign(grid.count(), kLung);
    labels.assign(grid.count(), kLabelBackground);
    drawn.assign(grid.count(), kUnlabelled);
    in_liver.assign(grid.count(), 0);
    std::size_t v = 0;
    for (int k = 0; k < 16; ++k) {
      for (int j = 0; j < 80; ++j) {
        for (int i = 0; i < 120; ++i, ++v) {
          const double from_lv = std::hypot(i - 32, j - 40);
          const double from_rv = std::hypot(i - 68, j - 40);
          const double from_liver = std::hypot(i - 100, j - 40);
          const auto put = [&](float value, std::uint8_t label) {
            image[v] = value;
            labels[v] = label;
          };
          if (from_rv < 16) put(kMuscle, kLabelRestOfHeart);
          if (from_rv < 13) put(kBlood, kLabelRvBlood);
          if (from_lv < 24) put(kMuscle, kLabelLvMyocardium);
          if (from_lv < 15) put(kBlood, kLabelLvBlood);
          if (from_liver >= 16) continue;
          put(kLiver, kLabelBackground);
          in_liver[v] = 1;
          // What the competition made of it in some slices.
          if (from_liver < 9 && k >= 4 && k < 8) labels[v] = kLabelRvBlood;
        }
      }
    }
    chambers.levels.blood = chambers.levels.rv_blood = kBlood;
    chambers.levels.muscle = kMuscle;
    chambers.levels.threshold = 0.5 * (kBlood + kMuscle);
    chambers.levels.dark = 0.5 * kMuscle;
    for (int k = 0; k < 16; ++k) {
      chambers.lv.push_back({k, {32, 40}, {}});
      chambers.lv.back().rings.resize(1);
    }
    chambers.base_step = 1;
    chambers.wall_mm = 9;
    chambers.wall_by_phase_mm = {9};
  }

  [[nodiscard]] int count_of(std::uint8_t label, bool liver) const {
    int count = 0;
    for (std::size_t v = 0; v < labels.size(); ++v) {
      count += labels[v] == label && (in_liver[v] != 0) == liver ? 1 : 0;
    }
    return count;
  }
};

TEST(Anatomy, liver_that_was_taken_for_blood_is_neither_ventricle_nor_its_wall) {
  Made heart(3);
  const int rv = heart.count_of(kLabelRvBlood, false);
  tidy_phase(heart.grid, heart.image, heart.chambers, 0, heart.drawn, heart.labels);
  for (const std::uint8_t label :
       {kLabelRvBlood, kLabelRestOfHeart, kLabelLvMyocardium, kLabelLvBlood}) {
    EXPECT_EQ(heart.count_of(label, true), 0) << static_cast<int>(label);
  }
  EXPECT_NEAR(heart.count_of(kLabelRvBlood, false), rv, 0.02 * rv);
  EXPECT_GT(heart.count_of(kLabelRestOfHeart, false), 0) << "the RV keeps its wall";
}

}  // namespace
}  // namespace beatlas::segment
