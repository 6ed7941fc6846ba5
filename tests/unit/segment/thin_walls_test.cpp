#include "pipeline/segment/thin_walls.h"

#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include "runtime/atlas/structures.h"
#include "tests/made_images.h"

namespace beatlas::segment::thin_walls_tests {
namespace {

constexpr int kSide = 60;
constexpr double kPixelMm = 1.5;
constexpr double kPriorMm = 2;  ///< a pixel of the prior
constexpr float kMuscle = 100;
constexpr float kBlood = 300;

/// A slice whose blood reaches as far as `blood_mm` from its middle, beside darker muscle, labelled
/// as the RV as far as 15 mm and as rest of the heart from there to 27 mm.
struct Section {
  ImageCycle<float> images;
  ImageCycle<std::uint8_t> labels;
};

double radius_mm(int i, int j) { return kPixelMm * std::hypot(i - 30, j - 30); }

Section section(double blood_mm) {
  Section out;
  out.images = made::constant_images(
      made::straight_grid({kSide, kSide, 1}, {kPixelMm, kPixelMm, 8}), 1, kMuscle);
  out.labels.grid = out.images.grid;
  out.labels.phases.emplace_back(out.images.grid.count(), kLabelBackground);
  for (int j = 0; j < kSide; ++j) {
    for (int i = 0; i < kSide; ++i) {
      const double r = radius_mm(i, j);
      const std::size_t v = out.images.grid.offset(i, j, 0);
      if (r <= blood_mm) out.images.phases[0][v] = kBlood;
      if (r <= 27) out.labels.phases[0][v] = r <= 15 ? kLabelRvBlood : kLabelRestOfHeart;
    }
  }
  return out;
}

tissue::TissueLevels levels() {
  tissue::TissueLevels out{.blood = kBlood, .rv_blood = kBlood, .muscle = kMuscle};
  out.part();
  return out;
}

/// Where along the row through the middle the RV's label ends [mm].
double end_mm(const Section& section) {
  double end = 0;
  for (int i = 30; i < kSide; ++i) {
    if (section.labels.phases[0][section.labels.grid.offset(i, 30, 0)] == kLabelRvBlood) {
      end = radius_mm(i, 30);
    }
  }
  return end;
}

TEST(ReachWalls, TakesInBloodWithinAPixelOfThePriorAndNoMore) {
  Section near = section(16.8);
  reach_walls(near.images, levels(), kPriorMm, near.labels);
  EXPECT_DOUBLE_EQ(end_mm(near), 16.5);
  Section far = section(24);
  reach_walls(far.images, levels(), kPriorMm, far.labels);
  // 2 mm and half a pixel beyond the outermost labelled centre: one pixel of 1.5 mm, of a prior of
  // 4 mm three.
  EXPECT_DOUBLE_EQ(end_mm(far), 16.5);
  Section coarse = section(24);
  reach_walls(coarse.images, levels(), 4, coarse.labels);
  EXPECT_DOUBLE_EQ(end_mm(coarse), 19.5);
}

TEST(ReachWalls, KnowsBloodThatIsDarkerThanMuscle) {
  Section dark = section(16.8);
  for (float& value : dark.images.phases[0]) value = kMuscle + kBlood - value;
  tissue::TissueLevels turned = levels();
  std::swap(turned.blood, turned.muscle);
  turned.rv_blood = turned.blood;
  reach_walls(dark.images, turned, kPriorMm, dark.labels);
  EXPECT_DOUBLE_EQ(end_mm(dark), 16.5);
}

TEST(ReachWalls, LeavesMuscleAndWhatIsNoHeart) {
  Section dark = section(15);
  const auto before = dark.labels.phases;
  reach_walls(dark.images, levels(), kPriorMm, dark.labels);
  EXPECT_EQ(dark.labels.phases, before);
  // Bright fat beside the cavity is background, however bright.
  Section fat = section(27);
  for (std::uint8_t& label : fat.labels.phases[0]) {
    if (label == kLabelRestOfHeart) label = kLabelBackground;
  }
  const auto as_labelled = fat.labels.phases;
  reach_walls(fat.images, levels(), kPriorMm, fat.labels);
  EXPECT_EQ(fat.labels.phases, as_labelled);
}

TEST(ReachWalls, GivesWhatLiesBetweenTwoCavitiesToTheNearerOne) {
  Section two = section(29);
  std::vector<std::uint8_t>& labels = two.labels.phases[0];
  // The right atrium begins two pixels beyond the RV, on one side.
  for (int j = 0; j < kSide; ++j) {
    for (int i = 43; i < 48; ++i) labels[two.labels.grid.offset(i, j, 0)] = kLabelRaBlood;
  }
  reach_walls(two.images, levels(), kPriorMm, two.labels);
  EXPECT_EQ(labels[two.labels.grid.offset(41, 30, 0)], kLabelRvBlood);
  EXPECT_EQ(labels[two.labels.grid.offset(42, 30, 0)], kLabelRaBlood);
}

}  // namespace
}  // namespace beatlas::segment::thin_walls_tests
